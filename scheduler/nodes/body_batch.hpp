// Bodies of a chunk that are moved many at once (kernels/bodies/motion_batch.hpp): those that live, have a free mass,
// turn little in a step and consist of few spheres, in steps without background damping, relaxation or a look of the
// monitor. Who calls it: body_motion.cpp, which moves all others. Invariant (I4): the same bits as one by one.
#pragma once

#include <array>

#include "kernels/bodies/motion_batch.hpp"
#include "scheduler/nodes/body_rows.hpp"

namespace talus {

/// Buffer of a thread. What lanes keep of a shape stays valid from chunk to chunk.
struct BodyBatch {
  MotionBatch lanes{};
  std::array<std::int32_t, MotionBatch::k_bodies> body{}, shape{}, spheres{};
  std::array<Row, MotionBatch::k_bodies> row{};
  BodyBatch() { shape.fill(-1); }
};

/// Made empty for the chunk, or null where its bodies are to be moved one by one.
BodyBatch* begin_batch(const BodyMotion& m);
bool fits_batch(const BodyMotion& m, std::int32_t b, Row i, const BodyShape& shape);
/// Body b, whose first row is i, comes in; a full batch is moved.
void enter_batch(const BodyMotion& m, BodyBatch& batch, std::int32_t b, Row i, const BodyShape& shape);
/// Moves what is in.
void move_batch(const BodyMotion& m, BodyBatch& batch);

}  // namespace talus
