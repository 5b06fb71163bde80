# The core: physics, knows no ROS. A new file of a room is found; how some files are compiled stands in the room.
add_library(${PROJECT_NAME}_core)
# By the alphabet: of inline functions that several files have, the linker keeps the first.
foreach(room batch dynamics effects lanes model ode reading run scene sensors simd)
  file(GLOB sources CONFIGURE_DEPENDS src/${room}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "avx[0-9]+\\.cpp$")
  target_sources(${PROJECT_NAME}_core PRIVATE ${sources})
endforeach()
# What runs once, when a scene is loaded or a matrix asked for: half of the time to compile it.
set(once $<$<CONFIG:Release>:-O1>)
# What calls its own functions at each evaluation: GCC then inlines them in a shared library, as Clang does.
set(calls_its_own $<$<CXX_COMPILER_ID:GNU>:-fno-semantic-interposition>)
foreach(room dynamics effects model ode reading scene simd lanes)
  include(src/${room}/room.cmake)
endforeach()

target_include_directories(${PROJECT_NAME}_core
  PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
if(NOT PLANAR_CHAIN_SANITIZE)
  # Line tables, for the counts of instructions and for profilers: they tell what was inlined from where, and change no
  # instruction. With tests or without: one build serves both.
  target_compile_options(${PROJECT_NAME}_core PRIVATE $<$<CONFIG:Release>:-g1>)
endif()
target_link_libraries(${PROJECT_NAME}_core PUBLIC Eigen3::Eigen
  PRIVATE ${TINYXML2_LIBRARY} ${YAML_CPP_LIBRARIES} Threads::Threads)
if(PLANAR_CHAIN_SANITIZE)
  target_compile_options(${PROJECT_NAME}_core PRIVATE -O1)  # or the tests take minutes
  # Here alone: elsewhere each file shows that it includes what it uses.
  target_precompile_headers(${PROJECT_NAME}_core PRIVATE
    <Eigen/Core> <algorithm> <cmath> <functional> <memory> <optional> <string> <vector>)
endif()
