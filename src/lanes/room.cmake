# The kernels: the same source for each kind of CPU, with the options of src/simd/room.cmake.
# GCC would compute what two kinds of joints share before it asks for the kind, and run out of registers.
set(kernel $<$<CXX_COMPILER_ID:GNU>:-fno-code-hoisting>)
# Pairs of pairs in two registers, which no other file takes.
set_source_files_properties(src/lanes/baseline.cpp src/lanes/columns_baseline.cpp PROPERTIES
  COMPILE_OPTIONS "-Wno-psabi;${kernel}")
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_sources(${PROJECT_NAME}_core PRIVATE src/lanes/avx2.cpp src/lanes/columns_avx2.cpp)
  set_source_files_properties(src/lanes/avx2.cpp src/lanes/columns_avx2.cpp PROPERTIES COMPILE_OPTIONS "${avx2};${kernel}")
  set_source_files_properties(src/lanes/column_series.cpp src/lanes/kernels.cpp PROPERTIES COMPILE_DEFINITIONS PLANAR_CHAIN_X86)
  # Some compilers do not know AVX-512. GCC 9 makes code for some sources that does not assemble.
  set(avx512 -mavx512f -mavx512dq -mavx512vl -mfma)
  if(NOT DEFINED AVX512_COMPILES)
    get_target_property(eigen Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
    set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
    set(CMAKE_TRY_COMPILE_CONFIGURATION Release)
    try_compile(AVX512_COMPILES ${PROJECT_BINARY_DIR}/avx512 ${PROJECT_SOURCE_DIR}/src/lanes/avx512.cpp
      CMAKE_FLAGS "-DINCLUDE_DIRECTORIES=${PROJECT_SOURCE_DIR}/src;${PROJECT_SOURCE_DIR}/include;${eigen}"
      COMPILE_DEFINITIONS ${avx512} CXX_STANDARD 17)
    unset(CMAKE_TRY_COMPILE_TARGET_TYPE)
    unset(CMAKE_TRY_COMPILE_CONFIGURATION)
  endif()
  if(AVX512_COMPILES)
    target_sources(${PROJECT_NAME}_core PRIVATE src/lanes/avx512.cpp src/lanes/columns_avx512.cpp)
    set_source_files_properties(src/lanes/avx512.cpp PROPERTIES COMPILE_OPTIONS "${avx512};${kernel}")
    # It takes no half registers.
    set_source_files_properties(src/lanes/columns_avx512.cpp PROPERTIES
      COMPILE_OPTIONS "${avx512};${kernel};-Wno-unused-function")
    set_property(SOURCE src/lanes/column_series.cpp src/lanes/kernels.cpp APPEND PROPERTY COMPILE_DEFINITIONS PLANAR_CHAIN_AVX512)
  else()
    message(STATUS "The compiler does not make the kernel for AVX-512: AVX2 is the best")
  endif()
endif()
if(PLANAR_CHAIN_SANITIZE)
  # Other options than the precompiled headers'.
  set_source_files_properties(src/lanes/avx2.cpp src/lanes/avx512.cpp src/lanes/baseline.cpp
    src/lanes/columns_avx2.cpp src/lanes/columns_avx512.cpp src/lanes/columns_baseline.cpp PROPERTIES
    SKIP_PRECOMPILE_HEADERS ON)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    # Hardly runs here: the address sanitizer's checks as calls, not inlined, are compiled in half of the time.
    set_source_files_properties(src/lanes/baseline.cpp PROPERTIES
      COMPILE_OPTIONS $<$<CXX_COMPILER_ID:GNU>:--param=asan-instrumentation-with-call-threshold=0>)
  endif()
endif()
