# NEURFRAME_SANITIZE and NEURFRAME_FUZZ: instrumentation of everything that is built.  The first report ends the
# program, so that no test passes with one; so does a failed assertion of Eigen or of the standard library.
# Optimized little: the compiler takes a third less time.  Clang is used for both, so that one build under ASan and
# UBSan serves the tests, the executables and the libFuzzer harnesses.
set(sanitizers ${NEURFRAME_SANITIZE})
if(NEURFRAME_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "NEURFRAME_FUZZ needs clang: -DCMAKE_CXX_COMPILER=clang++ (${CMAKE_CXX_COMPILER_ID} has no libFuzzer)")
  endif()
  set(sanitizers address undefined fuzzer-no-link)
endif()
if(sanitizers)
  list(JOIN sanitizers "," joined)
  target_compile_options(
    neurframe_options INTERFACE -fsanitize=${joined} -fno-sanitize-recover=all -fno-omit-frame-pointer -g1 -O1
    -UNDEBUG -D_GLIBCXX_ASSERTIONS)
  target_link_options(neurframe_options INTERFACE -fsanitize=${joined})
endif()
if("undefined" IN_LIST sanitizers AND CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  # a quarter of the time; Eigen's own assertions stay
  target_compile_options(neurframe_options INTERFACE -fsanitize-ignorelist=${CMAKE_CURRENT_LIST_DIR}/not_ours.txt)
endif()

# Half of the time that such a build takes would go into reading the headers of Eigen once per file.
if(sanitizers)
  set(empty_source ${CMAKE_CURRENT_BINARY_DIR}/precompiled.cpp)
  file(GENERATE OUTPUT ${empty_source} CONTENT "")
  add_library(neurframe_precompiled OBJECT ${empty_source})
  target_link_libraries(neurframe_precompiled PRIVATE neurframe_options neurframe_eigen)
  target_precompile_headers(neurframe_precompiled PRIVATE <Eigen/Dense> <Eigen/Sparse> <algorithm> <array> <cmath>
    <functional> <map> <set> <string> <vector>)
endif()

# neurframe_precompile(TARGET): the headers that all targets share, precompiled in sanitizer builds alone, so that
# every other build sees an include that is missing.
function(neurframe_precompile target)
  if(TARGET neurframe_precompiled)
    target_precompile_headers(${target} REUSE_FROM neurframe_precompiled)
  endif()
endfunction()
