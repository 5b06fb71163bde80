# Makes the target planar_chain::planar_chain; part of find_package(planar_chain), with catkin and without.
if(NOT TARGET planar_chain::planar_chain)  # else this package is part of the same build, as with catkin_make
  include(CMakeFindDependencyMacro)
  find_dependency(Eigen3)
  include(${planar_chain_DIR}/planar_chainTargets.cmake)
  get_target_property(planar_chain_kind planar_chain::planar_chain TYPE)
  if(planar_chain_kind STREQUAL "STATIC_LIBRARY")  # which leaves it to the program to link these
    find_dependency(Threads)
    find_dependency(yaml-cpp)
  endif()
endif()
