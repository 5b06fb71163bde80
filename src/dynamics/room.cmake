set_source_files_properties(src/dynamics/given_state.cpp src/dynamics/kane.cpp src/dynamics/linear_model.cpp PROPERTIES
  COMPILE_OPTIONS ${once})
set_source_files_properties(src/dynamics/general_motion.cpp src/dynamics/evaluation.cpp PROPERTIES
  COMPILE_OPTIONS ${calls_its_own})
