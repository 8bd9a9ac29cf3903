// [output] and [[output.plane]].
#include "core/frame/plane_count.hpp"
#include "core/scene/sections/sections.hpp"

namespace talus {
namespace {

const Keys<OutputSettings> k_output(
    {"output", false, "what is written, and how often"}, k_free,
    {
        key("particles_every", &OutputSettings::particles_every, "s", k_not_negative,
            "simulated time between particle frames; 0: none", "0.01")
            .also({{"interval", "output"}, {"every", "output"}, "dump_every", "frames_every"}),
        key("vtp", &OutputSettings::vtp,
            "particle frames as one .vtp file each, listed in a .pvd: any ParaView and VTK 9 open it", "false")
            .also({"vtk", "paraview"}),
        key("vtkhdf", &OutputSettings::vtkhdf, "particle frames in one VTKHDF file (ParaView 5.12 or newer)", "true")
            .also({"hdf5"}),
        key("csv_every", &OutputSettings::csv_every, "s", k_not_negative,
            "simulated time between rows of the time series; 0: none", "0.001")
            .also({"csv", "series_every"}),
        key("checkpoint_wall", &OutputSettings::checkpoint_wall, "s", k_not_negative,
            "wall time between checkpoints, of which the newest two are kept, so that a killed run loses no more; 0: "
            "only at the end; changes no result",
            "60")
            .also({{"checkpoint_every", "", "seconds of wall time; steps: --checkpoint-every"}}),
        key("energies", &OutputSettings::energies, "energy terms and balance", "true")
            .acts()  // off -> on is refused (scene_changes.cpp): not known to the record otherwise
            .also({{"energy", "output"}}),
        key("contacts", &OutputSettings::contacts,
            "contacts of every frame; none of two fixed grains that touch, between which no force is computed", "true"),
        key("coordination", &OutputSettings::coordination, "contacts per particle, without those of two fixed grains",
            "true"),
        key("stress", &OutputSettings::stress, "stress per particle; of a body that is no sphere that of all of it",
            "true"),
        other_key<OutputSettings>("grid", KeyType::cells, "-", {1, 10000}, "averages on a grid of this many cells",
                                  "[10, 10, 20]")
            .absent("(none)"),
    });

const Keys<OutputSettings::Plane> k_plane(
    {"output.plane", true, "a plane through which passages of grains are counted in every step, in number and mass"},
    fixed_by("its counts are part of the state"),
    {
        text_key<OutputSettings::Plane>("name", "unique name", "\"outlet\"").required(),
        key("point", &OutputSettings::Plane::point, "m", k_coordinate,
            "a point of the plane, which has to meet the domain; a grain passes with its centre, and on the plane "
            "exactly it is on the side of larger coordinates; across a periodic axis a plane counts once per round, at "
            "either end too",
            "[0, 0, 0.1]")
            .required(),
        direction_key("normal", &OutputSettings::Plane::normal,
                      "direction in which passages count as positive, against it as negative", "[0, 0, -1]"),
    });

}  // namespace

const SectionKeys& output_keys() { return k_output; }
const SectionKeys& output_plane_keys() { return k_plane; }

void read_output(const SceneTable& r, Scene& scene) {
  OutputSettings& o = scene.output;
  k_output.read(r, o);
  if (r.has("grid")) {
    o.grid.on = true;
    const std::vector<std::int64_t> cells = r.integers("grid");
    for (std::size_t k = 0; k < 3; ++k) o.grid.cells[k] = static_cast<int>(cells[k]);
  }
  std::vector<std::string> names;
  for (const SceneTable& p : r.sections("plane")) {
    OutputSettings::Plane& plane = o.flux_planes.emplace_back();
    k_plane.read(p, plane);
    plane.name = unique_name(p, "", names);
    if (!CountedPlane(scene.domain, plane).meets())
      p.fail("point", "the plane lies outside of the domain, where grains never are");
  }
  names.clear();
  for (const SceneTable& p : r.sections("region"))
    o.regions.push_back({unique_name(p, "", names), read_region(p, RegionOf::output, scene.domain, false)});
}

}  // namespace talus
