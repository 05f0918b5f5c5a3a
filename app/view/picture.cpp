#include "app/view/picture.hpp"

#include <fmt/format.h>

#include "app/output.hpp"
#include "app/view/headless_browser.hpp"
#include "app/view/saved_page.hpp"
#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"

namespace tactor {

namespace {

/// A browser that has drawn the page of the show.
class DrawnPage {
 public:
  DrawnPage(const Show& show, const PictureOptions& options) : browser(options.width, options.height) {
    const std::filesystem::path page = folder_.path() / "page.html";
    write_file(page, saved_page(show));
    const std::string moment = options.time ? fmt::format("{}", *options.time) : "force";
    browser.open(fmt::format("file://{}#picture={}&t={}", page.string(), options.whole_page ? "all" : "scene", moment));
    browser.wait_for("document.title.endsWith('(drawn)')");
  }

  HeadlessBrowser browser;

 private:
  TemporaryFolder folder_;
};

}  // namespace

void write_picture(const Show& show, const std::filesystem::path& png, const PictureOptions& options) {
  DrawnPage page(show, options);
  write_file(png, page.browser.screenshot());
}

void write_animation(const Show& show, const std::filesystem::path& svg, int count, double seconds,
                     const PictureOptions& options) {
  DrawnPage page(show, options);
  const std::vector<std::string> frames =
      page.browser.texts(fmt::format("window.tactor.frames(Array.from({{length: {0}}}, (_, i) => (i + 0.5) / {0} * "
                                     "window.tactor.hello.duration), {1}, {2})",
                                     count, options.width, options.height));
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\">\n"
      "<style>image {{ visibility: hidden; animation: show {2}s step-end infinite; }}\n"
      "@keyframes show {{ 0% {{ visibility: visible; }} {3:.4f}% {{ visibility: hidden; }} }}</style>\n",
      options.width, options.height, seconds, 100.0 / count);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double delay = seconds * static_cast<double>(i) / count - seconds;
    text += fmt::format("<image width=\"{}\" height=\"{}\" style=\"animation-delay: {:.4f}s\" href=\"{}\"/>\n",
                        options.width, options.height, delay, frames[i]);
  }
  write_file(svg, text + "</svg>\n");
}

}  // namespace tactor
