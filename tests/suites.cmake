# Run behind the build of a test program: every suite that PROGRAM lists becomes one test of ctest, PREFIX.SUITE, in OUTPUT. EMULATOR
# runs it, where it is for another processor.
execute_process(COMMAND ${EMULATOR} ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed RESULT_VARIABLE status TIMEOUT 60)
if(status)
  message(FATAL_ERROR "${PROGRAM} --gtest_list_tests: ${status}\n${listed}")
endif()
string(REGEX MATCHALL "(^|\n)[A-Za-z0-9_/]+\\." suites "${listed}")
list(REMOVE_DUPLICATES suites)
set(tests)
foreach(suite ${suites})
  string(REGEX REPLACE "[\n.]" "" suite "${suite}")
  string(APPEND tests "add_test([=[${PREFIX}.${suite}]=] ${EMULATOR} [=[${PROGRAM}]=] --gtest_brief=1 [=[--gtest_filter=${suite}.*]=])\n"
    "set_tests_properties([=[${PREFIX}.${suite}]=] PROPERTIES TIMEOUT 120)\n")
endforeach()
file(WRITE ${OUTPUT} "${tests}")
