set_source_files_properties(src/model/chain.cpp src/model/prismatic.cpp PROPERTIES COMPILE_OPTIONS ${once})
