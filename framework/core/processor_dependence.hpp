// Which parts of this process give other last digits on another processor, so that studies do not mix them unnoticed.
#pragma once

#include <string>
#include <vector>

namespace tactor {

/// Call this before computing with code that chooses its instructions by the processor, such as a BLAS.
/// `what` completes "... depends on the processor": `dynamics.deformable with solver: supernodal (a BLAS)`. Each text
/// is kept once. May be called by several threads.
void note_processor_dependence(const std::string& what);

/// All that has been noted in this process, in order of the texts. All else that Tactor computes is the same on every
/// x86-64 processor.
std::vector<std::string> processor_dependence();

}  // namespace tactor
