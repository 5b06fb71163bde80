# Studies of speed and exactness, and the report that shows them.
add_library(${PROJECT_NAME}_studies OBJECT src/report/contest.cpp src/report/own_methods.cpp)
target_link_libraries(${PROJECT_NAME}_studies ${PROJECT_NAME}_tools)
add_tool(batches src/report/batches.cpp)
add_tool(stability src/report/stability.cpp)
add_tool(report_measure src/report/measure.cpp)
target_link_libraries(${PROJECT_NAME}_stability ${PROJECT_NAME}_studies)
target_link_libraries(${PROJECT_NAME}_report_measure ${PROJECT_NAME}_studies)
set_source_files_properties(src/report/stability.cpp PROPERTIES COMPILE_OPTIONS ${once})
# Instrumented they would be tested for minutes, and show little that no other test does.
set_target_properties(${PROJECT_NAME}_studies ${PROJECT_NAME}_stability ${PROJECT_NAME}_report_measure
  PROPERTIES EXCLUDE_FROM_ALL ${PLANAR_CHAIN_SANITIZE})

# What the report says of how it was built: the commit is looked up at every build.
get_directory_property(report_flags COMPILE_OPTIONS)
string(REGEX REPLACE "\\$<[^;]*:([^;>]*)>" "\\1" report_flags "${CMAKE_CXX_FLAGS};${CMAKE_CXX_FLAGS_RELEASE};${report_flags}")
string(REPLACE ";" " " report_flags "${report_flags}")
add_custom_target(${PROJECT_NAME}_commit
  COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR} -DOUT=${PROJECT_BINARY_DIR}/report_build.h
    "-DCOMPILER=${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}" "-DFLAGS=${report_flags}"
    -P ${PROJECT_SOURCE_DIR}/src/report/build.cmake
  BYPRODUCTS ${PROJECT_BINARY_DIR}/report_build.h VERBATIM)
add_dependencies(${PROJECT_NAME}_report_measure ${PROJECT_NAME}_commit)
target_include_directories(${PROJECT_NAME}_report_measure PRIVATE ${PROJECT_BINARY_DIR})

# The report itself is a script; its modules and the templates of its pages lie beside it. readme.py is for makers.
link_in_devel(src/report/report.py lib/${PROJECT_NAME}/report)
install(PROGRAMS src/report/report.py DESTINATION ${to_bin} RENAME report)
file(GLOB modules RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS src/report/*.py src/report/*.jinja
  src/report/sections/*.jinja)
list(REMOVE_ITEM modules src/report/report.py src/report/readme.py)
install(FILES ${modules} DESTINATION ${to_bin})
file(GLOB peers RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS src/report/peers/*.py)
install(PROGRAMS ${peers} DESTINATION ${to_bin}/peers)
