// The pages of the reference, each group from the declarations that the program itself uses.
#pragma once

#include <set>
#include <string>

#include "app/verbs/reference/markdown.hpp"
#include "app/verbs/verb_info.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

/// What the pages are made from.
struct ReferenceSource {
  Registry& registry;           ///< with all libraries loaded
  std::set<std::string> types;  ///< the node types of these
  VerbInfo command;
};

/// nodes.md, and a page a node type.
void add_node_pages(const ReferenceSource& source, Pages& pages);
/// metrics_list.md: what runs report.
void add_metric_page(const ReferenceSource& source, Pages& pages);
/// message_types.md: fields, units and frames.
void add_message_page(const ReferenceSource& source, Pages& pages);
/// verbs.md, and a page a verb.
void add_verb_pages(const ReferenceSource& source, Pages& pages);
/// graph_keys.md: the keys of graph and study files.
void add_key_page(const ReferenceSource& source, Pages& pages);

/// Metrics as rows of a table: name, unit, which is better, what it is.
void add_metric_table(const std::vector<MetricInfo>& metrics, PageWriter& page);

/// Manual pages by their file names: `tactor.1`, and `tactor-VERB.1` for each verb; `date` as `2026-01-31`.
Pages manual_pages(const VerbInfo& command, const std::string& version, const std::string& date);

}  // namespace tactor
