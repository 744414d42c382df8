// neurframe-hexex: the hex mesh of an integer-grid map.
#include <algorithm>
#include <string>

#include "core/hex_map_io.hpp"
#include "core/program.hpp"
#include "hexex/build_grid_map.hpp"
#include "hexex/extract_hexes.hpp"

namespace neurframe {
namespace {

constexpr std::size_t most_located_losses = 1000;

CommandLine command_line() {
  return {"neurframe-hexex",
          "Extracts the hex mesh of an integer-grid map (text format of HexEx), exactly and in parallel.",
          {"MAP.hexex"},
          {{"--output", "-o", "OUT", "hex mesh: .mesh (MEDIT), .vtk (legacy) or .ovm", true},
           {"--locations", "", "FILE", "per vertex of OUT: tet of MAP and 4 barycentric coordinates"},
           {"--partial-boundary", "", "", "allow boundary faces that lie on no integer plane"}}};
}

// The centre of a lost cell in space.
Point3 centre_of(const GridMap& map, const LostCell& lost) {
  return position(map, locate(map, {lost.tet, lost.centre}));
}

void report_map(const GridMap& map, const MapReport& report, Json& statistics) {
  statistics["tets"] = map.P.size();
  statistics["tet_vertices"] = map.mesh.V.size();
  statistics["fraction_bits"] = map.fraction_bits;
  statistics["parametric_volume"] = report.parametric_volume;
  statistics["flipped_tets"] = report.flipped_tets;
  statistics["flat_tets"] = report.flat_tets;
  statistics["turned_tets"] = report.orientation.turned_tets;
  statistics["mirrored_components"] = report.orientation.mirrored_components;
  statistics["unaligned_boundary_faces"] = report.unaligned_boundary_faces;
  statistics["contradictory_vertices"] = report.seamless.contradictory_vertices;
  statistics["inexact_faces"] = report.seamless.broken_faces;
  statistics["largest_move_to_seamless"] = report.seamless.largest_move;
}

void report_losses(const GridMap& map, const Extraction& extraction, Json& statistics) {
  Json& lost = statistics["lost_cells"];
  lost["total"] = extraction.lost.size();
  Json& causes = lost["causes"];
  for (const LostCell& cell : extraction.lost) {
    Json& count = causes[loss_name(cell.loss)];
    count = count.integer_or(0) + 1;
  }
  std::vector<Json> places;
  for (std::size_t i = 0; i < std::min(extraction.lost.size(), most_located_losses); ++i) {
    const Point3 p = centre_of(map, extraction.lost[i]);
    Json place;
    place["cause"] = loss_name(extraction.lost[i].loss);
    place["tet"] = extraction.lost[i].tet;
    place["at"] = std::vector<double>(p.begin(), p.end());
    places.push_back(place);
  }
  lost["places"] = places;
}

// The corners of turned tets were swapped; the file lists them in the order of MAP.
void write_locations(const std::string& path, const GridMap& map, const std::vector<Location>& locations) {
  TextWriter out(path);
  for (const Location& location : locations) {
    std::array<double, 4> w = location.weights;
    if (map.turned[static_cast<std::size_t>(location.tet)] != 0) std::swap(w[2], w[3]);
    out << location.tet << ' ' << w[0] << ' ' << w[1] << ' ' << w[2] << ' ' << w[3] << '\n';
  }
  out.commit();
}

ExitCode extract(const Arguments& arguments, Json& statistics) {
  const int threads = worker_threads(arguments);
  const std::string output = arguments.text("--output");
  check_hex_format(output);
  report_progress(0.0, "reading");
  HexMap real = read_hex_map(arguments.positional(0));
  report_progress(0.2, "exact map");
  MapReport report;
  const GridMap map = build_grid_map(std::move(real), arguments.given("--partial-boundary"), threads, report);
  const Extraction extraction = extract_hexes(map, threads, [](double fraction, const std::string& step) {
    report_progress(0.3 + 0.6 * fraction, step);
  });
  report_progress(0.9, "writing");
  write_hex_mesh(output, extraction.mesh);
  if (arguments.given("--locations"))
    write_locations(arguments.text("--locations"), map, extraction.locations);
  report_map(map, report, statistics);
  statistics["hexes"] = extraction.mesh.H.size();
  statistics["vertices"] = extraction.mesh.V.size();
  statistics["folded_cells"] = extraction.folded_cells;
  statistics["joined_vertices"] = extraction.joined_vertices;
  report_losses(map, extraction, statistics);
  // every cell of the map has volume one, so an extraction without loss has as many hexes as there is volume
  const bool complete = extraction.lost.empty() && report.whole_volume &&
                        report.parametric_volume == static_cast<double>(extraction.mesh.H.size());
  statistics["complete"] = complete;
  report_progress(1.0, "done");
  return complete ? ExitCode::done : ExitCode::incomplete;
}

}  // namespace
}  // namespace neurframe

int main(int argc, char** argv) {
  return neurframe::run_program(neurframe::command_line(), argc, argv, neurframe::extract);
}
