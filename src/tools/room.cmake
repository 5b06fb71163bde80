# The tools: command line, know no ROS.
add_library(${PROJECT_NAME}_tools STATIC src/tools/common.cpp)
target_link_libraries(${PROJECT_NAME}_tools PUBLIC ${PROJECT_NAME}_core Boost::program_options)

# The program NAME, installed but where the sanitizers are, with which not all of them are built.
function(add_tool name source)
  add_executable(${PROJECT_NAME}_${name} ${source})
  set_target_properties(${PROJECT_NAME}_${name} PROPERTIES OUTPUT_NAME ${name})
  target_link_libraries(${PROJECT_NAME}_${name} ${PROJECT_NAME}_tools nlohmann_json::nlohmann_json)
  if(NOT PLANAR_CHAIN_SANITIZE)
    install(TARGETS ${PROJECT_NAME}_${name} RUNTIME DESTINATION ${to_bin})
  endif()
endfunction()
add_tool(equations src/tools/equations.cpp)
target_sources(${PROJECT_NAME}_equations PRIVATE src/tools/chain_json.cpp)
add_tool(simulate src/tools/simulate.cpp)
set_source_files_properties(src/tools/equations.cpp src/tools/simulate.cpp PROPERTIES COMPILE_OPTIONS ${once})
set_source_files_properties(src/tools/simulate.cpp PROPERTIES
  COMPILE_DEFINITIONS PLANAR_CHAIN_BAGS="$<$<BOOL:${PLANAR_CHAIN_ROS}>:lib${PROJECT_NAME}_bags.so>")
target_link_libraries(${PROJECT_NAME}_simulate ${CMAKE_DL_LIBS})

# Those in Python: what begins with #! is a program, the others are modules that it imports. show needs ROS; plot needs
# nothing, the others need the Python module.
file(GLOB scripts RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS src/tools/*.py)
foreach(script ${scripts})
  get_filename_component(name ${script} NAME_WE)
  file(READ ${script} begin LIMIT 2)
  if(NOT begin MATCHES "^#!")
    get_filename_component(module ${script} REALPATH)  # some are links into the Python module
    install(FILES ${module} DESTINATION ${to_bin})
  elseif(name STREQUAL "plot" OR (name STREQUAL "show" AND PLANAR_CHAIN_ROS) OR
      (NOT name STREQUAL "show" AND TARGET ${PROJECT_NAME}_python))
    install(PROGRAMS ${script} DESTINATION ${to_bin} RENAME ${name})
    link_in_devel(${script} lib/${PROJECT_NAME}/${name})
  endif()
endforeach()
install(DIRECTORY src/python/${PROJECT_NAME}/drawing DESTINATION ${to_bin} FILES_MATCHING PATTERN "*.py")  # a link to it is here
