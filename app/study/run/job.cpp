#include "app/study/run/job.hpp"

#include "app/study/run/job_fields.hpp"

namespace tactor {

std::string to_message(const Job& job) {
  return to_bytes(job);
}
std::string to_message(const JobCost& cost) {
  return to_bytes(cost);
}
std::string to_message(const CaseCheck& check) {
  return to_bytes(check);
}
std::string to_message(const WarmUp& warm_up) {
  return to_bytes(warm_up);
}
std::string to_message(const RunAnswer& answer) {
  return to_bytes(answer);
}

template <class T>
T from_message(const std::string& text) {
  return from_bytes<T>(text);
}
template Job from_message<Job>(const std::string&);
template JobCost from_message<JobCost>(const std::string&);
template CaseCheck from_message<CaseCheck>(const std::string&);
template WarmUp from_message<WarmUp>(const std::string&);
template RunAnswer from_message<RunAnswer>(const std::string&);

}  // namespace tactor
