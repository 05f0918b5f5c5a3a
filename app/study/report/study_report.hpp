// The page of a study: every graph by every configuration, as tables.
#pragma once

#include <string>

#include "app/study/table/study.hpp"

namespace tactor {

/// The report of a study: every graph by every configuration, errors and run times side by side.
std::string study_report(const Study& study);

}  // namespace tactor
