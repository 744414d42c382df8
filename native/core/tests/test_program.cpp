// Command line, JSON, exit codes, and the deterministic parallel loops.
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <numeric>
#include <stdexcept>

#include "core/parallel.hpp"
#include "core/program.hpp"
#include "core/testing.hpp"

using namespace neurframe;

static CommandLine sample_command() {
  return {"tool",
          "does things",
          {"MAP"},
          {{"--output", "-o", "OUT", "the result", true}, {"--fast", "", "", "no care"}}};
}

static void test_arguments() {
  const Arguments given = parse_arguments(sample_command(), {"in.obj", "-o", "out.obj", "--fast"});
  CHECK(given.positional(0) == "in.obj");
  CHECK(given.text("--output") == "out.obj");
  CHECK(given.given("--fast") && !given.given("--slow"));
  CHECK_THROWS(parse_arguments(sample_command(), {"in.obj"}), InputError, "--output OUT is missing");
  CHECK_THROWS(parse_arguments(sample_command(), {"-o", "x"}), InputError, "MAP is missing");
  CHECK_THROWS(parse_arguments(sample_command(), {"a", "b", "-o", "x"}), InputError, "surplus argument 'b'");
  CHECK_THROWS(parse_arguments(sample_command(), {"a", "--slow"}), InputError, "unknown option '--slow'");
  CHECK_THROWS(parse_arguments(sample_command(), {"a", "-o"}), InputError, "needs a value");
  CHECK_THROWS(parse_arguments(sample_command(), {"a", "-o", "x", "-o", "y"}), InputError, "given twice");
}

static void test_numbers() {
  const Arguments given = parse_arguments({"tool", "", {}, {{"-n", "", "N", ""}}}, {"-n", "12x"});
  CHECK_THROWS(given.integer("-n", 1, 0, 99), InputError, "found '12x'");
  const Arguments negative = parse_arguments({"tool", "", {}, {{"-n", "", "N", ""}}}, {"-n", "-5"});
  CHECK(negative.integer("-n", 1, -9, 9) == -5);
  CHECK_THROWS(negative.integer("-n", 1, 0, 9), InputError, "from 0 to 9");
  CHECK_THROWS(negative.number("-n", 1.0, 0.0, 9.0), InputError, "a number");
  CHECK(negative.integer("-m", 7, 0, 9) == 7);
}

static int exit_status(const ProgramBody& body) {
  char name[] = "tool";
  char* argv[] = {name, nullptr};
  return run_program({"tool", "", {}, {}}, 1, argv, body);
}

static void test_exit_codes() {
  CHECK(exit_status([](const Arguments&, Json&) { return ExitCode::done; }) == 0);
  CHECK(exit_status([](const Arguments&, Json&) { return ExitCode::incomplete; }) == 4);
  CHECK(exit_status([](const Arguments&, Json&) -> ExitCode { throw InputError("bad file"); }) == 2);
  CHECK(exit_status([](const Arguments&, Json&) -> ExitCode { throw StageError("no luck"); }) == 3);
  CHECK(exit_status([](const Arguments&, Json&) -> ExitCode { throw std::bad_alloc(); }) == 3);
  CHECK(exit_status([](const Arguments&, Json&) -> ExitCode { throw std::out_of_range("i"); }) == 3);
}

// Names and words of files come into messages: they stay one line and harmless on a terminal.
static void test_one_line() {
  CHECK(in_one_line("a\nb\033[2Jc\x7f \xc3\xa9") == "a?b?[2Jc? \xc3\xa9");
}

static void test_json() {
  Json json;
  json["tets"] = 12;
  json["seconds"] = 0.5;
  json["nan"] = std::nan("");
  json["name"] = "a\"b\\\n";
  json["list"] = std::vector<int>{1, 2};
  json["inner"]["done"] = true;
  CHECK(json.dump() ==
        "{\"tets\": 12, \"seconds\": 0.5, \"nan\": null, \"name\": \"a\\\"b\\\\\\u000a\", "
        "\"list\": [1, 2], \"inner\": {\"done\": true}}");
}

static std::vector<std::int64_t> collected_squares(int threads) {
  return parallel_collect<std::int64_t>(10'000, threads, [](std::int64_t begin, std::int64_t end, auto& out) {
    for (std::int64_t i = begin; i < end; ++i) {
      if (i % 3 == 0) out.push_back(i * i);
    }
  });
}

static void test_parallel() {
  const std::vector<std::int64_t> squares = collected_squares(1);
  CHECK(squares.size() == 3334 && squares.back() == 9999 * 9999);
  CHECK(collected_squares(2) == squares && collected_squares(5) == squares);
  std::vector<int> hits(5000, 0);
  parallel_for(5000, 3, [&](std::int64_t i) { ++hits[static_cast<std::size_t>(i)]; });
  CHECK(std::accumulate(hits.begin(), hits.end(), 0) == 5000);
  const auto failing = [](std::int64_t i) {
    if (i >= 4000) throw InputError("item 4000 or later");
  };
  CHECK_THROWS(parallel_for(5000, 3, failing), InputError, "item 4000");
}

// Where the address space ends no more threads are to be had; sanitizers need all of it for themselves.
static void test_refused_threads() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || defined(__clang__)
  return;
#endif
  std::ifstream statm("/proc/self/statm");
  rlim_t pages = 0;
  statm >> pages;
  rlimit before{};
  getrlimit(RLIMIT_AS, &before);
  const rlimit tight{pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + (64 << 20), before.rlim_max};
  std::atomic<int> calls{0};
  CHECK(setrlimit(RLIMIT_AS, &tight) == 0);
  parallel_chunks(1024, 1024, [&](std::int64_t, std::int64_t, std::int64_t) { ++calls; }, 1);
  setrlimit(RLIMIT_AS, &before);
  CHECK(calls == 1024);
}

int main() {
  test_arguments();
  test_numbers();
  test_exit_codes();
  test_one_line();
  test_json();
  test_parallel();
  test_refused_threads();
  return test_result();
}
