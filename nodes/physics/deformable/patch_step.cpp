#include "nodes/physics/deformable/patch_step.hpp"

#include "nodes/physics/mechanics/eigen.hpp"

namespace tactor {

PatchStep::PatchStep(const ElasticModel& model, const PatchChoice& patch)
    : model_(model), patch_(patch), arrays_(RigidStep::most_patch_nodes) {
  touching_.reserve(ContactSet::capacity);
}

/// Takes those contacts whose free nodes are all in the patch. Returns how many of the others overlap.
int PatchStep::take_contacts(const std::vector<SoftContact>& found) {
  touching_.clear();
  int left_out = 0;
  for (SoftContact contact : found) {
    bool known = true;
    for (std::int32_t& node : contact.node) {
      const bool fixed = model_.unknown_of(node) < 0;
      node = fixed ? -1 : patch_.place_of(node);
      known = known && (fixed || node >= 0);
    }
    if (known) {
      touching_.push_back(contact);
    } else if (contact.contact.distance < 0) {
      ++left_out;
    }
  }
  return left_out;
}

StepResult PatchStep::advance(RigidStep& rigid_step, const StepInput& input, const StepContacts& contacts,
                              const StepFactor& factor, const Eigen::VectorXd& x_free, double solved,
                              NodeEquation& equation, BodyStates& bodies) {
  const int left_out = take_contacts(contacts.found());
  equation.contact_force().setZero();
  StepResult result;
  if (touching_.empty()) {
    result = rigid_step.advance(input.coupling, input.before, input.device, input.rigid, input.h, bodies);
  } else {
    const std::vector<int>& nodes = patch_.nodes();
    const Eigen::VectorXd &x0 = equation.x0(), &v0 = equation.v0();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const int x_at = 3 * nodes[i], u = model_.unknown_of(nodes[i]);
      const auto row = static_cast<Eigen::Index>(3 * i);
      arrays_.p_W[i] = plain(x0.segment<3>(x_at));
      arrays_.query_p_W[i] = plain(contacts.x().segment<3>(x_at));
      arrays_.velocity.segment<3>(row) = v0.segment<3>(u);
      arrays_.free_velocity.segment<3>(row) = (x_free.segment<3>(x_at) - x0.segment<3>(x_at)) / solved;
    }
    arrays_.inertia = solved * solved * factor.schur();
    const BodyStates& query = contacts.bodies();
    const SoftPatch patch =
        arrays_.patch(nodes.size(), touching_, std::span(query.X_WB).first(static_cast<std::size_t>(query.count)));
    result = rigid_step.advance(patch, input.coupling, input.before, input.device, input.rigid, input.h, bodies,
                                arrays_.motion(nodes.size()));
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      equation.contact_force().segment<3>(model_.unknown_of(nodes[i])) =
          arrays_.force.segment<3>(static_cast<Eigen::Index>(3 * i));
    }
  }
  result.left_out += left_out;
  return result;
}

}  // namespace tactor
