#include "miq/map_problem.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <string>

#include "core/errors.hpp"
#include "miq/field_topology.hpp"

namespace neurframe {
namespace {

// Interior singular vertices by quarter turns, and irregular feature sectors.
Json singularity_histogram(const std::vector<Sector>& sectors) {
  std::map<int, int> interior;
  int on_features = 0;
  for (const Sector& sector : sectors) {
    if (sector.closed && sector.quarter_turns != 4) ++interior[sector.quarter_turns];
    if (!sector.closed && sector.quarter_turns != 2) ++on_features;
  }
  Json json;
  for (const auto& [turns, count] : interior) json[std::to_string(turns)] = count;
  json["feature_sectors"] = on_features;
  return json;
}

// Poincare-Hopf: the quarter turns that all vertices lack add up to 4 times the Euler characteristic.
void require_poincare_hopf(const CrossSurface& surface, const std::vector<Sector>& sectors,
                           Json& statistics) {
  std::vector<int> lacking(surface.positions.size(), 0);
  int edges = 0;
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    edges += h > surface.twin(h);
    if (surface.twin(h) < 0) lacking[static_cast<size_t>(surface.from(h))] = -2;
  }
  int vertices = 0;
  for (const int h : outgoing_half_edges(surface)) {
    if (h < 0) continue;
    ++vertices;
    lacking[static_cast<size_t>(surface.from(h))] += 4;
  }
  int sum = 0;
  for (const int quarter_turns : lacking) sum += quarter_turns;
  for (const Sector& sector : sectors) sum -= sector.quarter_turns;
  const int euler = vertices - edges + surface.triangle_count();
  statistics["euler_characteristic"] = euler;
  if (sum != 4 * euler) {
    throw StageError("the singularities of the crosses have index " + std::to_string(sum) +
                     "/4 in all, the surface " + std::to_string(euler) +
                     ": are there triangles without area?");
  }
}

// Cancels, repairs and smooths until the matchings can carry a map.
std::vector<Sector> mend_field(CrossSurface& surface, const PreparationOptions& options, double edge_length,
                               Json& statistics) {
  std::vector<Sector> sectors = measure_sectors(surface);
  require_poincare_hopf(surface, sectors, statistics);
  statistics["singularities_of_input"] = singularity_histogram(sectors);
  const double reach = options.dipole_reach * edge_length;
  FieldTopology topology(surface, sectors);
  statistics["turns_repaired"] = repair_sectors(topology, options.closed_minimum, reach);
  statistics["dipoles_cancelled"] = cancel_dipoles(topology, reach);
  const double clearance = options.feature_clearance * edge_length;
  statistics["singularities_retreated"] = retreat_from_features(topology, clearance);
  relax_field(surface, topology.shifted(), 2 * std::max(reach, clearance));
  statistics["turns_traded"] =
      trade_singularities(surface, sectors, {options.trade_reach * edge_length, options.singularity_penalty});
  statistics["singularities"] = singularity_histogram(sectors);
  return sectors;
}

void split_around_critical(MapProblem& problem, Json& statistics) {
  CrossSurface& surface = problem.surface;
  std::vector<char> critical = singular_vertices(surface, problem.sectors);
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (!surface.is_feature(h)) continue;
    critical[static_cast<size_t>(surface.from(h))] = 1;
    critical[static_cast<size_t>(surface.to(h))] = 1;
  }
  statistics["splits"]["critical"] = split_between_critical(surface, critical);
  problem.singular = singular_vertices(surface, measure_sectors(surface));
  statistics["splits"]["singular_stars"] = refine_singular_stars(surface, problem.singular);
  problem.sectors = measure_sectors(surface);
  problem.singular = singular_vertices(surface, problem.sectors);
}

MapProblem solve_topology(CrossSurface surface, const PreparationOptions& options, double edge_length,
                          Json& statistics) {
  MapProblem problem;
  problem.surface = std::move(surface);
  statistics["largest_feature_turn_deg"] = align_to_features(problem.surface) * 180 / std::numbers::pi;
  compute_matchings(problem.surface);
  problem.sectors = mend_field(problem.surface, options, edge_length, statistics);
  split_around_critical(problem, statistics);
  const std::vector<char> crossed = comb(problem.surface);
  problem.graph = build_cut_graph(problem.surface, crossed, problem.singular);
  problem.variables = reduce_variables(problem.surface, problem.graph, problem.singular);
  return problem;
}

// Feature edges whose ends coincide for random values of all unknowns, as vertex pairs.  Boundary edges stay.
std::set<std::pair<int, int>> degenerate_features(const MapProblem& problem) {
  std::mt19937 generator(1);
  std::uniform_int_distribution<int> draw(-1000000, 1000000);
  std::vector<int64_t> real(static_cast<size_t>(problem.variables.real_count));
  std::vector<int64_t> integer(static_cast<size_t>(problem.variables.integer_count));
  for (int64_t& x : real) x = draw(generator);
  for (int64_t& x : integer) x = draw(generator);
  const auto value = [&](int corner, int parameter) {
    const int sector = problem.variables.sector[static_cast<size_t>(corner)];
    const ReducedCoordinate& x = problem.variables.coordinates[static_cast<size_t>(2 * sector + parameter)];
    int64_t total = x.real >= 0 ? x.sign * real[static_cast<size_t>(x.real)] : 0;
    for (const auto& [index, factor] : x.integers) total += factor * integer[static_cast<size_t>(index)];
    return total;
  };
  std::set<std::pair<int, int>> pairs;
  const CrossSurface& surface = problem.surface;
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (!surface.is_feature(h) || surface.twin(h) < 0) continue;
    const int k = CrossSurface::next(h);
    if (value(h, 0) == value(k, 0) && value(h, 1) == value(k, 1))
      pairs.insert({surface.from(h), surface.to(h)});
  }
  return pairs;
}

int release_features(CrossSurface& surface, const std::set<std::pair<int, int>>& pairs) {
  int released = 0;
  for (int h = 0; h < surface.half_edge_count(); ++h) {
    if (pairs.count({surface.from(h), surface.to(h)}) == 0) continue;
    surface.feature[static_cast<size_t>(h)] = 0;
    ++released;
  }
  return released / 2;
}

}  // namespace

CrossSurface build_cross_surface(const TriangleMesh& mesh, const std::vector<std::array<double, 6>>& crosses,
                                 const std::vector<double>& sizing, Json& statistics) {
  CrossSurface surface;
  for (const Point3& p : mesh.V) surface.positions.emplace_back(p[0], p[1], p[2]);
  surface.triangles = mesh.F;
  pair_half_edges(surface);
  statistics["vertices_split"] = split_nonmanifold_vertices(surface);
  for (int f = 0; f < surface.triangle_count(); ++f) {
    const auto k = static_cast<size_t>(f);
    if (!(surface.area(f) > 0)) throw InputError("triangle " + std::to_string(f) + " has no area");
    const Eigen::Vector3d normal = surface.normal(f);
    Eigen::Vector3d axis(crosses[k][0], crosses[k][1], crosses[k][2]);
    axis -= normal * normal.dot(axis);
    if (!(axis.norm() > 1e-6))
      throw InputError("the cross of triangle " + std::to_string(f) + " is not tangent");
    surface.axis.push_back(axis.normalized());
    double size = 1;
    if (!sizing.empty()) {
      size = 0;
      for (const int v : mesh.F[k]) size += sizing[static_cast<size_t>(v)] / 3;
    }
    surface.size.push_back(size);
    surface.source.push_back(f);
  }
  surface.matching.assign(static_cast<size_t>(surface.half_edge_count()), 0);
  return surface;
}

MapProblem prepare_map_problem(CrossSurface surface, const PreparationOptions& options, double edge_length,
                               Json& statistics) {
  constexpr int kMostReleases = 4;
  FeatureOptions features = options.features;
  features.shortest_line = std::max(features.shortest_line, 4 * edge_length);
  mark_features(surface, features);
  int released = release_lines(surface, features.released_at);
  statistics["splits"]["long_edges"] = split_long_edges(surface, options.longest_edge * edge_length);
  statistics["splits"]["features"] = split_around_features(surface);
  MapProblem problem = solve_topology(surface, options, edge_length, statistics);
  for (int round = 0; round < kMostReleases; ++round) {
    const int now = release_features(surface, degenerate_features(problem));
    if (now == 0) break;
    released += now;
    problem = solve_topology(surface, options, edge_length, statistics);
  }
  statistics["feature_edges_released"] = released;
  statistics["triangles"] = problem.surface.triangle_count();
  statistics["seam_branches"] = problem.graph.branches.size();
  statistics["real_variables"] = problem.variables.real_count;
  statistics["integer_variables"] = problem.variables.integer_count;
  return problem;
}

}  // namespace neurframe
