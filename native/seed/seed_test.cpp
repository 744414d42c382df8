// Run with the library preloaded and NEURFRAME_SEED=42: two devices give one sequence, and that of the seed.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <random>

namespace {

std::array<unsigned, 4> draw(const char* seed) {
  setenv("NEURFRAME_SEED", seed, 1);
  std::random_device device;
  return {device(), device(), device(), device()};
}

}  // namespace

int main() {
  const auto first = draw("42");
  const auto again = draw("42");
  const auto other = draw("43");
  if (first != again || first == other || first[0] == first[1]) {
    std::puts("std::random_device does not follow NEURFRAME_SEED: is the library preloaded?");
    return 1;
  }
  return 0;
}
