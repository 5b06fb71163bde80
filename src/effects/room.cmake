set_source_files_properties(src/effects/friction.cpp src/effects/stick_slip.cpp PROPERTIES
  COMPILE_OPTIONS ${calls_its_own})
