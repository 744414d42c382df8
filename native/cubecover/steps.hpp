// The steps of the method as a user sees them: their progress and their CPU seconds.
#pragma once

#include <algorithm>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

namespace neurframe {

struct StepTime {
  std::string step;
  double cpu_seconds;  // of all tries together
};

using ProgressCallback = std::function<void(double fraction, const std::string& step)>;

// Runs the steps, says so, and adds up their CPU seconds.
class Steps {
 public:
  explicit Steps(const ProgressCallback& progress) : progress_(progress) {}

  template <class Body>
  auto run(double fraction, const std::string& name, const Body& body) {
    progress_(fraction, name);
    const Timer timer{times_, name, std::clock()};
    return body();
  }

  const std::vector<StepTime>& times() const { return times_; }

 private:
  struct Timer {
    std::vector<StepTime>& times;
    std::string name;
    std::clock_t start;
    ~Timer() {
      const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
      const auto found =
          std::find_if(times.begin(), times.end(), [&](const StepTime& t) { return t.step == name; });
      if (found != times.end()) {
        found->cpu_seconds += seconds;
      } else {
        times.push_back({name, seconds});
      }
    }
  };

  const ProgressCallback& progress_;
  std::vector<StepTime> times_;
};

}  // namespace neurframe
