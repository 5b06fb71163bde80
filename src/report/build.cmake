# Writes OUT, a header that says which commit of SOURCE is built, by what; only if it has changed.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=7
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(commit "not known")
endif()
string(REPLACE "\"" "\\\"" FLAGS "${FLAGS}")
file(WRITE ${OUT}.new "#define PLANAR_CHAIN_ABOUT R\"about({\"commit\": \"${commit}\", \"compiler\": \"${COMPILER}\", \"flags\": \"${FLAGS}\"})about\"
")
execute_process(COMMAND ${CMAKE_COMMAND} -E copy_if_different ${OUT}.new ${OUT})
