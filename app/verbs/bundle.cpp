// `tactor bundle`: what a machine without an installation needs, as one archive.
#include "app/bundle/bundle.hpp"

#include <CLI/CLI.hpp>
#include <memory>

#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

void add_bundle(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand(
      "bundle",
      "Pack the program, its libraries, and studies with every file they read into one archive for a cluster");
  const auto request = std::make_shared<BundleRequest>();
  verb->add_option("studies", request->studies, "Study files (YAML)")->type_name(value_type::study)->required();
  verb->add_option("--out", request->out, "The archive to write, NAME.tar.gz")->type_name(value_type::file)->required();
  verb->add_flag("--overwrite", request->overwrite, "Replace an existing archive");
  verb->callback([request, &exit_code] {
    for (std::filesystem::path& study : request->studies) study = named_file(study, study_files);
    write_bundle(*request);
    exit_code = 0;
  });
}

}  // namespace tactor
