#include "app/view/saved_page.hpp"

#include <zlib.h>

#include <array>
#include <cstdint>
#include <cstring>

#include "app/base64.hpp"
#include "app/view/view_server.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr int gzip_window = 15 + 16;  // of zlib: with the header of gzip

std::string gzip(const std::string& bytes) {
  z_stream stream{};
  TACTOR_DEMAND(deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, gzip_window, 8, Z_DEFAULT_STRATEGY) == Z_OK);
  std::string packed(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  TACTOR_DEMAND(deflate(&stream, Z_FINISH) == Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

std::string gunzip(std::string_view packed) {
  z_stream stream{};
  TACTOR_DEMAND(inflateInit2(&stream, gzip_window) == Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  std::string bytes;
  std::array<char, 65536> part{};
  int state = Z_OK;
  while (state == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(part.data());
    stream.avail_out = static_cast<uInt>(part.size());
    state = inflate(&stream, Z_NO_FLUSH);
    bytes.append(part.data(), part.size() - stream.avail_out);
  }
  TACTOR_DEMAND(state == Z_STREAM_END);
  inflateEnd(&stream);
  return bytes;
}

void pack(std::string& packed, bool binary, const std::string& message) {
  const std::array<std::uint32_t, 2> head{binary ? 1U : 0U, static_cast<std::uint32_t>(message.size())};
  packed.append(reinterpret_cast<const char*>(head.data()), sizeof head);
  packed += message;
  packed.append((8 - packed.size() % 8) % 8, '\0');
}

std::string program() {
  for (const ViewFile& file : load_view_library().files()) {
    if (std::string_view(file.path) == "/saved.html") return gunzip(file.gzip);
  }
  throw InputError("this build has no page that could be saved");
}

}  // namespace

std::string saved_page(const Show& show) {
  constexpr std::string_view place = "<!--TACTOR_RECORDING-->";
  std::string page = program();
  const std::size_t at = page.find(place);
  TACTOR_DEMAND(at != std::string::npos);
  std::string packed;
  pack(packed, false, show.hello);
  for (const std::string& mesh : show.meshes) pack(packed, true, mesh);
  for (const std::string& frame : show.frames) pack(packed, true, frame);
  page.replace(at, place.size(), "<script id=\"recording\" type=\"text/plain\">" + base64(gzip(packed)) + "</script>");
  return page;
}

}  // namespace tactor
