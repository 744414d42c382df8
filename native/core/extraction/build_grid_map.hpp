// From real parameters to the exact map: transitions, fixed point; or the reason why it is no integer-grid
// map.
#pragma once

#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "core/errors.hpp"
#include "core/extraction/extract_cells.hpp"
#include "core/extraction/make_seamless.hpp"
#include "core/extraction/recover_transitions.hpp"

namespace neurframe {

struct MapReport {
  SeamlessReport seamless;
  int boundary_facets = 0;
  int unaligned_boundary_facets = 0;
  int flipped = 0;
  int flat = 0;
  double parametric_volume = 0.0;  // in cells: the number of cells of a map without flaws
  bool whole_volume = false;       // it is exactly an integer
};

template <int N>
struct SimplexNames;
template <>
struct SimplexNames<2> {
  static constexpr const char* simplex = "triangle";
  static constexpr const char* facet = "edge";
  static constexpr const char* plane = "isoline";
};
template <>
struct SimplexNames<3> {
  static constexpr const char* simplex = "tet";
  static constexpr const char* facet = "face";
  static constexpr const char* plane = "isosurface";
};

namespace detail {

template <std::size_t Size>
std::string as_text(const std::array<double, Size>& u) {
  std::string text = "(";
  for (std::size_t k = 0; k < Size; ++k) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%s%.6g", k == 0 ? "" : ", ", u[k]);
    text += digits;
  }
  return text + ")";
}

template <int N>
std::string facet_name(const GridMap<N>& map, int h) {
  std::string name = SimplexNames<N>::facet;
  const char* separator = " ";
  for (const int v : facet_vertices<N>(map.S, h)) {
    name += separator;
    name += std::to_string(v);
    separator = "-";
  }
  return name;
}

}  // namespace detail

// Raises InputError when charts do not fit, which no extraction can mend.
template <int N>
void refuse_impossible_facets(const GridMap<N>& map, const RealParameters<N>& real,
                              const RecoveredTransitions<N>& found) {
  if (found.impossible.empty()) return;
  const int h = found.impossible.front();
  const int t = h / (N + 1);
  const int s = map.twin[static_cast<std::size_t>(h)] / (N + 1);
  const auto choice =
      detail::best_transition(detail::seen_from(map, real, h, t), detail::seen_from(map, real, h, s));
  const std::string what =
      choice.residual > map_tolerance
          ? "no rotation of the grid carries one image to the other (off by " +
                std::to_string(choice.residual) + ")"
          : "translation " + detail::as_text(choice.translation) + ", allowed are integers";
  throw InputError("not an integer-grid map: at " + std::to_string(found.impossible.size()) + " interior " +
                   SimplexNames<N>::facet + "s the charts differ by no grid symmetry; first " +
                   detail::facet_name(map, h) + " of " + SimplexNames<N>::simplex + "s " + std::to_string(t) +
                   " and " + std::to_string(s) + ": " + what + "; a seamless map has to be quantized first");
}

template <int N>
void refuse_unaligned_boundary(const GridMap<N>& map, const RealParameters<N>& real,
                               const RecoveredTransitions<N>& found, int boundary_facets) {
  if (found.unaligned.empty()) return;
  const int h = found.unaligned.front();
  std::string parameters;
  for (const RealPoint<N>& u : detail::seen_from(map, real, h, h / (N + 1))) {
    parameters += ' ';
    parameters += detail::as_text(u);
  }
  throw InputError("not an integer-grid map: " + std::to_string(found.unaligned.size()) + " of " +
                   std::to_string(boundary_facets) + " boundary " + SimplexNames<N>::facet +
                   "s lie on no integer " + SimplexNames<N>::plane + "; first " + detail::facet_name(map, h) +
                   " of " + SimplexNames<N>::simplex + " " + std::to_string(h / (N + 1)) +
                   " with parameters" + parameters +
                   "; --partial-boundary extracts the complete cells all the same");
}

// Raises InputError for parameters too large for exact arithmetic.
template <int N>
int fraction_bits_of(const RealParameters<N>& real) {
  double largest = 0.0;
  for (const auto& corners : real) {
    for (const RealPoint<N>& u : corners) largest = std::max(largest, detail::largest_entry(u));
  }
  const int bits = fraction_bits_for(largest);
  if (bits == 0) {
    throw InputError("a parameter of " + std::to_string(largest) + " cells; allowed are parameters below 2^" +
                     std::to_string(fixed_total_bits - fixed_least_fraction_bits));
  }
  return bits;
}

// A sum of exact volumes in whole cells and a rest, of which no partial sum overflows.
class VolumeSum {
 public:
  explicit VolumeSum(Int128 cell) : cell_(cell) {}

  // |volume| < 2^126, and |rest_| < 2^125 before
  void add(Int128 volume) {
    rest_ += volume;
    if (rest_ < -most_rest || rest_ > most_rest) carry();
  }

  // Divisions of 128 bits are slow: only where the rest has grown, and at the end.
  void carry() {
    whole_ += rest_ / cell_;
    rest_ %= cell_;
  }

  bool is_whole() const { return rest_ == 0; }
  double cells() const {
    return static_cast<double>(whole_) + static_cast<double>(rest_) / static_cast<double>(cell_);
  }

 private:
  static constexpr Int128 most_rest = Int128{1} << 125;

  Int128 cell_;
  Int128 whole_ = 0;
  Int128 rest_ = 0;
};

// Signs of the simplices and the total volume, all exact.
template <int N>
void measure_volume(GridMap<N>& map, MapReport& report) {
  map.orientation.resize(map.S.size());
  map.touches_flat.assign(map.V.size(), 0);
  VolumeSum sum((N == 3 ? 6 : 2) * (Int128{1} << (N * map.fraction_bits)));
  for (std::size_t t = 0; t < map.P.size(); ++t) {
    const Int128 volume = signed_measure(map.P[t]);
    map.orientation[t] = static_cast<std::int8_t>(sign_of(volume));
    sum.add(volume);
    report.flipped += volume < 0 ? 1 : 0;
    report.flat += volume == 0 ? 1 : 0;
    if (volume != 0) continue;
    for (const int v : map.S[t]) map.touches_flat[static_cast<std::size_t>(v)] = 1;
  }
  sum.carry();
  report.whole_volume = sum.is_whole();
  report.parametric_volume = sum.cells();
}

// Fills the exact part of a map whose V, S and twin are set, with the transitions found.
template <int N>
void complete_grid_map(const RealParameters<N>& real, RecoveredTransitions<N> found, int threads,
                       GridMap<N>& map, MapReport& report) {
  report.seamless = make_seamless(real, std::move(found), threads, map);
  measure_volume(map, report);
}

}  // namespace neurframe
