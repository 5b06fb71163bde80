set_source_files_properties(src/reading/describe.cpp src/reading/section.cpp src/reading/value.cpp PROPERTIES
  COMPILE_OPTIONS ${once})
