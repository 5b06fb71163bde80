set_source_files_properties(src/scene/scene_numbers.cpp src/scene/scene_reader.cpp PROPERTIES COMPILE_OPTIONS ${once})
