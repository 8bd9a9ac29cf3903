// What a changing radius does to the elastic energy of contacts: nodes add to each row the derivative of that energy
// with respect to its radius. Who calls it: the contact_force and wall_contact nodes of scenes with balance and changing
// sizes; who reads it: the ledger. Formulae: the laws in kernels/models.
#pragma once

#include "scheduler/nodes/surface.hpp"
#include "scheduler/state/contacts.hpp"
#include "scheduler/state/ledger.hpp"

namespace talus {

/// Elastic energy of a contact's normal direction [J], and its derivatives by the radii of both partners [N].
struct SizePush {
  double energy = 0, i = 0, j = 0;
};
/// Of two spheres at a distance; rj < 0: a plane. `pair`: material pair. `turned`: energy of rolling and twisting
/// springs [J], whose stiffness goes with R*^2.
SizePush size_push(const Rules& rules, int pair, double ri, double rj, double distance, double turned);

/// Behind the forces of the chunk's pairs, and behind those of its walls.
void push_pairs(const Rules& rules, const Rows& rows, Ledger& ledger, const Chunk& c);
void push_walls(const Rules& rules, const Rows& rows, const WallSet& walls, Ledger& ledger, const Chunk& c);

/// Behind all forces of the chunk, ahead of its integration: the rows that lead bodies get the derivative by their
/// scale [J], the others nothing. A sphere of a body moves with the scale, against the force on it.
void push_bodies(const Rules& rules, const Rows& rows, Ledger& ledger, const Chunk& c);

}  // namespace talus
