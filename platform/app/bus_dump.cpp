#include "app/bus_dump.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>
#include <vector>

#include "app/packet_printer.hpp"
#include "errors.hpp"

namespace polhode::platform {
namespace {

constexpr std::size_t kChunkOctets =
    1U << 16U;  // some hundred packets; memory does not depend on the file's size

struct Close {
  void operator()(std::FILE* stream) const { std::fclose(stream); }
};

}  // namespace

void dump_bus(const BusDumpArguments& arguments) {
  // Without waiting: a FIFO that nobody writes to would never open.
  const int opened = ::open(arguments.file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  struct stat status {};
  if (opened >= 0 && (::fstat(opened, &status) != 0 || !S_ISREG(status.st_mode))) {
    ::close(opened);
    throw UnusableInput(fmt::format("{}: not a regular file", arguments.file.string()));
  }
  const std::unique_ptr<std::FILE, Close> in(opened < 0 ? nullptr : ::fdopen(opened, "rb"));
  if (!in) {
    throw UnusableInput(
        fmt::format("{}: {}", arguments.file.string(), std::generic_category().message(errno)));
  }
  PacketPrinter printer({.source = arguments.file.string(),
                         .json = arguments.json,
                         .apid_first = arguments.apid_first});
  StreamReader reader;
  std::vector<std::uint8_t> chunk(kChunkOctets);
  bool at_end = false;
  while (!at_end) {
    const std::size_t count = std::fread(chunk.data(), 1, chunk.size(), in.get());
    if (std::ferror(in.get()) != 0) {
      throw UnusableInput(fmt::format("{}: cannot be read: {}",
                                      arguments.file.string(),
                                      std::generic_category().message(errno)));
    }
    at_end = count == 0;
    reader.add(std::span(chunk).first(count), at_end, printer);
  }
  if (printer.packets() == 0 && printer.damaged_octets() != 0) {
    throw UnusableInput(fmt::format("{}: holds no packet", arguments.file.string()));
  }
  printer.finish();
}

}  // namespace polhode::platform
