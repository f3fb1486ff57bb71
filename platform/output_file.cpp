#include "output_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <system_error>

#include "errors.hpp"

namespace polhode::platform {

OutputFile::OutputFile(const std::filesystem::path& file)
    : name_(file.string()), stream_(std::fopen(file.c_str(), "wbe")) {
  if (!stream_) {
    fail();
  }
}

void OutputFile::write(const void* data, std::size_t octets) {
  if (octets != 0 && std::fwrite(data, 1, octets, stream_.get()) != octets) {
    fail();
  }
}

void OutputFile::close() {
  std::FILE* stream = stream_.release();
  if (stream != nullptr && std::fclose(stream) != 0) {
    fail();
  }
}

void OutputFile::fail() const {
  throw RunFailure(
      fmt::format("{}: cannot be written: {}", name_, std::generic_category().message(errno)));
}

void write_file(const std::filesystem::path& file, std::string_view text) {
  OutputFile out(file);
  out.write(text);
  out.close();
}

}  // namespace polhode::platform
