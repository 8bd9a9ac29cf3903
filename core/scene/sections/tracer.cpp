// [tracer], and the tracer of a [[source]]: keys of the part in scheduler/parts/tracer.cpp.
#include "core/scene/sections/parts.hpp"

namespace talus {
namespace {

const Keys<Scene> k_tracer(
    {"tracer", false,
     "a passive scalar of each grain that contacts mix, but for those of two fixed grains; absent: no grain has one"},
    fixed_by("the grains have exchanged it at this rate"),
    {
        key("rate", &Scene::tracer_rate, "1/s", k_not_negative,
            "dc/dt = rate * sum over the contacts of (their c - c), of a clump those of all its spheres; 0: it only "
            "follows the grains. Particle files gain "
            "`tracer`, the series tracer.total, tracer.residual (total + removed - inserted) and tracer.mixing_index "
            "(Lacey 1954: 0 unmixed, 1 mixed at random)",
            "2.5")
            .required(),
    });

const Keys<Source> k_source({"source", true, ""}, fixed_by("its grains have begun with it"),
                            {key("tracer", &Source::tracer, "-", k_finite,
                                 "tracer that its grains begin with; needs [tracer]", "1")
                                 .with("[tracer]\nrate = 2.5\n")});

void read(const SceneTable& root, Scene& scene) {
  const bool on = root.has("tracer");
  if (on) k_tracer.read(root.section("tracer"), scene);
  const std::vector<SceneTable> sources = root.sections("source");
  for (std::size_t k = 0; k < sources.size(); ++k) {
    k_source.read(sources[k], scene.sources[k]);
    if (!on && sources[k].has("tracer")) sources[k].fail("tracer", "has no effect without a [tracer] section");
  }
}

}  // namespace

const PartSections& tracer_sections() {
  static const PartSections all{{&k_tracer, &k_source}, read};
  return all;
}

}  // namespace talus
