# One source for each kind of CPU; which one runs is found out at run time.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_sources(${PROJECT_NAME}_core PRIVATE src/simd/avx2.cpp)
  # Before GCC 10, an unaligned load is split in two by default.
  set(avx2 -mavx2 -mfma
    $<$<CXX_COMPILER_ID:GNU>:-mno-avx256-split-unaligned-load>
    $<$<CXX_COMPILER_ID:GNU>:-mno-avx256-split-unaligned-store>)
  set_source_files_properties(src/simd/avx2.cpp PROPERTIES COMPILE_OPTIONS "${avx2}")
  set_source_files_properties(src/simd/cpu.cpp src/simd/vectors.cpp PROPERTIES COMPILE_DEFINITIONS PLANAR_CHAIN_X86)
endif()
if(PLANAR_CHAIN_SANITIZE)  # other options than the precompiled headers'
  set_source_files_properties(src/simd/avx2.cpp src/simd/baseline.cpp PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
endif()
