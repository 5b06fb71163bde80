set_source_files_properties(src/ode/radau_table.cpp PROPERTIES COMPILE_OPTIONS ${once})
if(PLANAR_CHAIN_SANITIZE)
  # Eigen's decompositions for one table of numbers: to instrument them takes a minute. Other options than the
  # precompiled headers'.
  set_source_files_properties(src/ode/radau_table.cpp PROPERTIES
    COMPILE_OPTIONS -fno-sanitize=undefined SKIP_PRECOMPILE_HEADERS ON)
endif()
