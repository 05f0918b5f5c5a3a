// What makes the contacts of a scene doubtful before anything has moved: what a user should know, and nothing stops
// for.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "framework/node/node.hpp"
#include "nodes/physics/contact/contact_body.hpp"

namespace tactor {

/// Bodies whose contact samples are so far apart that much of a penetration may be missed: farther than a quarter of
/// the longest side of a mesh or a box, or than the radius of a capsule. `sampled[i]`: the spacing counts for body i.
std::vector<std::string> doubts_of_spacing(std::span<const ContactBody> bodies, const std::vector<bool>& sampled,
                                           double spacing);

/// Where the hand leads the tool, bodies[0]: where nothing else moves, nowhere near any body, by a sphere about the
/// tool and boxes about the others; and farther from all of them than a hundred times the longest of them.
std::vector<std::string> doubts_of_path(std::span<const ContactBody> bodies, const HandPath& hand);

/// A body that starts inside another: deeper than a third of the shortest side of the thinner one. `depth` in m.
std::vector<std::string> doubts_of_start(const ContactBody& a, const ContactBody& b, double depth);

}  // namespace tactor
