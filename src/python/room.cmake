# The Python module. It shares its folder with the messages. catkin_python_setup() would want a setup.py beside
# CMakeLists.txt.
if(EXISTS "${python_headers}/Python.h" AND NOT PLANAR_CHAIN_SANITIZE AND NOT CMAKE_CROSSCOMPILING)
  set(PYBIND11_NOPYTHON ON)  # it would look for a python of its own, that of ROS 2
  find_package(pybind11 CONFIG QUIET)
endif()
if(NOT pybind11_FOUND)
  if(SKBUILD)
    message(FATAL_ERROR "pip needs pybind11 here without its own environment")
  endif()
  message(STATUS "No Python module: it needs pybind11 (./test/run installs it), and a build for the python that is here")
  return()
endif()

set(python_package ${devel_space}/lib/python3/dist-packages/${PROJECT_NAME})
file(GLOB_RECURSE files RELATIVE ${PROJECT_SOURCE_DIR}/src/python/${PROJECT_NAME} CONFIGURE_DEPENDS
  src/python/${PROJECT_NAME}/*.py src/python/${PROJECT_NAME}/*.pyi src/python/${PROJECT_NAME}/py.typed)
foreach(file ${files})
  configure_file(src/python/${PROJECT_NAME}/${file} ${python_package}/${file} COPYONLY)
endforeach()
file(RELATIVE_PATH from_package "/prefix/${to_python}" /prefix)  # to the folder of lib and share
file(GLOB sources CONFIGURE_DEPENDS src/python/*.cpp)
add_library(${PROJECT_NAME}_python MODULE ${sources})
set_target_properties(${PROJECT_NAME}_python PROPERTIES
  PREFIX "" OUTPUT_NAME _core SUFFIX ${python_suffix} LIBRARY_OUTPUT_DIRECTORY ${python_package}
  CXX_VISIBILITY_PRESET hidden INSTALL_RPATH "$ORIGIN/${from_package}lib")
target_compile_options(${PROJECT_NAME}_python PRIVATE ${once})
set_source_files_properties(src/python/scene.cpp PROPERTIES COMPILE_DEFINITIONS PREFIX="${from_package}")
target_include_directories(${PROJECT_NAME}_python SYSTEM PRIVATE ${pybind11_INCLUDE_DIR} ${python_headers})
target_link_libraries(${PROJECT_NAME}_python ${PROJECT_NAME}_core)
set_target_properties(${PROJECT_NAME}_core PROPERTIES POSITION_INDEPENDENT_CODE ON)
install(TARGETS ${PROJECT_NAME}_python DESTINATION ${to_python})
if(SKBUILD)
  install(FILES src/python/console.py DESTINATION ${to_python})
endif()
if(NOT PLANAR_CHAIN_ROS)  # else the files beside it are installed with the messages
  install(DIRECTORY src/python/${PROJECT_NAME}/ DESTINATION ${to_python}
    FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN py.typed)
endif()
