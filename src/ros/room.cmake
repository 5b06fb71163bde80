# The node: a coat of ROS around the core.
file(GLOB sources CONFIGURE_DEPENDS src/ros/node/*.cpp src/ros/view/*.cpp)
list(FILTER sources EXCLUDE REGEX "/main\\.cpp$")
add_library(${PROJECT_NAME}_ros ${sources})
add_dependencies(${PROJECT_NAME}_ros ${${PROJECT_NAME}_EXPORTED_TARGETS})
target_include_directories(${PROJECT_NAME}_ros SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
target_link_libraries(${PROJECT_NAME}_ros PUBLIC ${PROJECT_NAME}_core ${catkin_LIBRARIES})

# simulate loads it when a run reads or writes a bag.
file(GLOB sources CONFIGURE_DEPENDS src/ros/bag/*.cpp)
add_library(${PROJECT_NAME}_bags MODULE ${sources})
target_include_directories(${PROJECT_NAME}_bags SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
target_link_libraries(${PROJECT_NAME}_bags ${PROJECT_NAME}_ros)
add_dependencies(${PROJECT_NAME}_simulate ${PROJECT_NAME}_bags)

add_executable(${PROJECT_NAME}_node src/ros/node/main.cpp)
add_executable(${PROJECT_NAME}_pull src/ros/pull/mouse_drag.cpp)
set_target_properties(${PROJECT_NAME}_pull PROPERTIES OUTPUT_NAME pull)
foreach(program node pull)
  target_include_directories(${PROJECT_NAME}_${program} SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
  target_link_libraries(${PROJECT_NAME}_${program} ${PROJECT_NAME}_ros)
endforeach()

install(TARGETS ${PROJECT_NAME}_bags ${PROJECT_NAME}_ros
  ARCHIVE DESTINATION ${to_lib}
  LIBRARY DESTINATION ${to_lib}
  RUNTIME DESTINATION ${CATKIN_GLOBAL_BIN_DESTINATION})
install(TARGETS ${PROJECT_NAME}_node ${PROJECT_NAME}_pull RUNTIME DESTINATION ${to_bin})
