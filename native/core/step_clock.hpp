// CPU seconds per step of a program, for its statistics.
#pragma once

#include <ctime>
#include <string>

#include "core/json.hpp"

namespace neurframe {

class StepClock {
 public:
  explicit StepClock(Json& seconds) : seconds_(seconds) {}

  // Books the CPU time (of all threads) since the previous call, or the construction, under this name.
  void finish(const std::string& step) {
    const std::clock_t now = std::clock();
    seconds_[step] = static_cast<double>(now - last_) / CLOCKS_PER_SEC;
    last_ = now;
  }

 private:
  Json& seconds_;
  std::clock_t last_ = std::clock();
};

}  // namespace neurframe
