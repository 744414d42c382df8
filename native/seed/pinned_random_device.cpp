// std::random_device with a seed.
//
// fTetWild shuffles the order in which it inserts triangles with a generator seeded from std::random_device,
// so two runs give two meshes.  Preloaded (LD_PRELOAD) into its process, these definitions come before
// libstdc++'s: every random_device then yields the same sequence, a function of the environment variable
// NEURFRAME_SEED.
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>

namespace {

std::uint64_t seed_from_environment() {
  const char* text = std::getenv("NEURFRAME_SEED");
  return text == nullptr ? 0 : std::strtoull(text, nullptr, 10);
}

// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014): any seed, zero too, gives well-mixed bits
std::uint64_t next_bits(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15ULL;
  std::uint64_t bits = state;
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9ULL;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebULL;
  return bits ^ (bits >> 31);
}

// one state a thread: what a thread draws does not depend on what the others do
thread_local std::uint64_t state = seed_from_environment();

}  // namespace

namespace std {

void random_device::_M_init(const std::string&) {
  state = seed_from_environment();
}
void random_device::_M_init_pretr1(const std::string&) {
  state = seed_from_environment();
}
void random_device::_M_fini() {}
random_device::result_type random_device::_M_getval() {
  return static_cast<result_type>(next_bits(state) >> 32);
}
random_device::result_type random_device::_M_getval_pretr1() {
  return _M_getval();
}
double random_device::_M_getentropy() const noexcept {
  return 0.0;
}

}  // namespace std
