// Checks for the unit-test programs: a failed check is printed with its place, the program goes on, and
// `return test_result();` at the end of main() makes ctest see it.
#pragma once

#include <cmath>
#include <cstdio>
#include <string>

namespace neurframe {

struct TestTally {
  int checks = 0;
  int failures = 0;
};

inline TestTally& test_tally() {
  static TestTally tally;
  return tally;
}

inline bool record_check(bool passed, const char* what, const char* file, int line) {
  ++test_tally().checks;
  if (!passed) {
    ++test_tally().failures;
    std::printf("%s:%d: failed: %s\n", file, line, what);
  }
  return passed;
}

// A test program without checks is a failure too.
inline int test_result() {
  const TestTally& tally = test_tally();
  std::printf("%d checks, %d failures\n", tally.checks, tally.failures);
  return tally.checks > 0 && tally.failures == 0 ? 0 : 1;
}

}  // namespace neurframe

#define CHECK(condition) ::neurframe::record_check((condition), #condition, __FILE__, __LINE__)
#define CHECK_NEAR(a, b, tolerance) \
  ::neurframe::record_check(std::abs((a) - (b)) <= (tolerance), #a " is near " #b, __FILE__, __LINE__)
// The expression must throw an exception of this type whose message contains the text.
#define CHECK_THROWS(expression, type, text)                                                         \
  do {                                                                                               \
    bool caught_as_expected = false;                                                                 \
    try {                                                                                            \
      (void)(expression);                                                                            \
    } catch (const type& error) {                                                                    \
      caught_as_expected = std::string(error.what()).find(text) != std::string::npos;                \
      if (!caught_as_expected) std::printf("message was: %s\n", error.what());                       \
    }                                                                                                \
    ::neurframe::record_check(caught_as_expected, #expression " throws " #type, __FILE__, __LINE__); \
  } while (false)
