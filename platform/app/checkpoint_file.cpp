#include "app/checkpoint_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/crypto.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <system_error>

#include "base/crc.hpp"
#include "os/linux/descriptor.hpp"
#include "os/linux/file_owner.hpp"
#include "pipeline/checkpoint.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

using Mac = std::array<std::uint8_t, POLHODE_MAC_OCTETS>;

/// Read by the same build on the same machine only: as it lies in memory.
struct FileHeader {
  std::array<char, 8> magic{'P', 'L', 'H', 'C', 'H', 'K', '0', '3'};
  CheckpointIdentity identity;
  std::uint32_t content_crc32 = 0;
  std::uint32_t restarts = 0;
  Moment stepped;
  std::array<char, 36> boot_id{};  ///< of the machine, when it was written
  std::uint32_t is_signed = 0;
  std::uint64_t content_bytes = 0;
  Mac content_mac{};  ///< zeros where it is not signed
  Mac mac{};          ///< over all before it
  std::uint32_t spare = 0;
  std::uint32_t header_crc32 = 0;
};
static_assert(sizeof(FileHeader) == 240, "no gaps: checksum and MAC go over all octets");

std::uint32_t crc_of(const FileHeader& header) {
  return crc32_iso_hdlc(
      {reinterpret_cast<const std::uint8_t*>(&header), sizeof header - sizeof header.header_crc32});
}

/// Not signed, and without its own sum.
FileHeader header_of(const CheckpointStamp& stamp, std::span<const std::uint8_t> content) {
  return {.identity = stamp.identity,
          .content_crc32 = crc32_iso_hdlc(content),
          .restarts = stamp.restarts,
          .stepped = stamp.stepped,
          .boot_id = stamp.boot_id,
          .content_bytes = content.size()};
}

/// @return false: OpenSSL failed.
bool sign(const polhode_key& key, std::span<const std::uint8_t> content, FileHeader* header) {
  header->is_signed = 1;
  return polhode_mac(&key, content.data(), content.size(), header->content_mac.data()) == 0 &&
         polhode_mac(&key,
                     reinterpret_cast<const std::uint8_t*>(header),
                     offsetof(FileHeader, mac),
                     header->mac.data()) == 0;
}

bool is_signed_by(const polhode_key& key,
                  const FileHeader& header,
                  std::span<const std::uint8_t> content) {
  FileHeader expected = header;
  return header.is_signed == 1 && sign(key, content, &expected) &&
         CRYPTO_memcmp(&expected, &header, offsetof(FileHeader, mac) + sizeof header.mac) == 0;
}

bool write_all(int file, const void* data, std::size_t bytes) {
  const auto* at = static_cast<const std::uint8_t*>(data);
  while (bytes > 0) {
    const ssize_t written = ::write(file, at, bytes);
    if (written <= 0) {
      return false;
    }
    at += written;
    bytes -= static_cast<std::size_t>(written);
  }
  return true;
}

/// A rename is on the disk when its folder is.
void sync_folder_of(const fs::path& file) {
  std::array<char, 4096> folder{};
  const char* name = file.c_str();
  const char* slash = std::strrchr(name, '/');
  const std::size_t length = slash == nullptr ? 0 : static_cast<std::size_t>(slash - name);
  if (length + 1 >= folder.size()) {
    return;
  }
  const char* root_or_here = slash == nullptr ? "." : "/";
  std::memcpy(folder.data(), length == 0 ? root_or_here : name, length == 0 ? 1 : length);
  const int descriptor = ::open(folder.data(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor >= 0) {
    (void)::fsync(descriptor);
    ::close(descriptor);
  }
}

std::string damage_of(const FileHeader& header,
                      std::span<const std::uint8_t> content,
                      const BuildId& build) {
  if (header.magic != FileHeader{}.magic || header.header_crc32 != crc_of(header)) {
    return "not a checkpoint, or its beginning is damaged";
  }
  if (header.content_bytes != content.size() || header.content_crc32 != crc32_iso_hdlc(content)) {
    return "torn or damaged";
  }
  return header.identity.build_id != build ? "of another build" : "";
}

std::string foreign_in(const FileHeader& header, const CheckpointIdentity& identity) {
  if (header.identity.config_hash != identity.config_hash) {
    return "of another configuration";
  }
  return header.identity.boot_id != identity.boot_id ? "from before the machine was started" : "";
}

/// Monotonic clocks of two boots are not comparable: then the UTC clock is used, which may be set.
double age_s(const FileHeader& header, const Moment& now) {
  const std::array<char, 36> boot = this_boot();
  const bool is_same = boot == header.boot_id && boot != std::array<char, 36>{};
  const std::int64_t age_ns = is_same ? now.since_boot_ns - header.stepped.since_boot_ns
                                      : now.utc_ns - header.stepped.utc_ns;
  return 1e-9 * static_cast<double>(age_ns);
}

bool read_all(int file, void* data, std::size_t bytes) {
  auto* at = static_cast<std::uint8_t*>(data);
  while (bytes > 0) {
    const ssize_t got = ::read(file, at, bytes);
    if (got <= 0) {
      return false;
    }
    at += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

/// @return why it cannot be read; empty when it has been.
std::string read_whole(const fs::path& file, FileHeader* header, LoadedCheckpoint* loaded) {
  const Descriptor in(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));  // a FIFO waits
  struct stat status {};
  if (in.get() < 0 || ::fstat(in.get(), &status) != 0) {
    return fmt::format("cannot be read: {}", std::generic_category().message(errno));
  }
  if (!S_ISREG(status.st_mode)) {
    return "no file";
  }
  const auto bytes = static_cast<std::size_t>(status.st_size);
  if (bytes < sizeof *header) {
    return "too short";
  }
  if (bytes > sizeof *header + checkpoint_octets_max()) {
    return "too long";
  }
  loaded->memory = std::make_unique<TableMemory>(bytes);
  const std::span<std::byte> whole = loaded->memory->span().first(bytes);
  if (!read_all(in.get(), whole.data(), whole.size())) {
    return "cannot be read to its end";
  }
  std::memcpy(header, whole.data(), sizeof *header);
  loaded->bytes = {reinterpret_cast<const std::uint8_t*>(whole.data()), whole.size()};
  loaded->content = loaded->bytes.subspan(sizeof *header);
  loaded->checksum = header->header_crc32;
  loaded->stranger = problem_of_owner(in.get(), S_IWGRP | S_IWOTH);
  loaded->restarts = header->restarts;
  return {};
}

LoadedCheckpoint load(const fs::path& file, const BuildId& build, FileHeader* header) {
  LoadedCheckpoint loaded;
  loaded.refusal = read_whole(file, header, &loaded);
  if (loaded.refusal.empty()) {
    loaded.refusal = damage_of(*header, loaded.content, build);
  }
  return loaded;
}

/// Nothing of a refused one is used.
LoadedCheckpoint validated(LoadedCheckpoint loaded) {
  if (!loaded.refusal.empty()) {
    loaded.bytes = loaded.content = {};
    loaded.restarts = loaded.checksum = 0;
  }
  return loaded;
}

}  // namespace

std::array<char, 36> this_boot() {
  std::array<char, 36> id{};
  std::ifstream in("/proc/sys/kernel/random/boot_id");
  in.read(id.data(), id.size());
  return in ? id : std::array<char, 36>{};
}

fs::path checkpoint_before(const fs::path& file) { return file.string() + ".before"; }

CheckpointPlaces::CheckpointPlaces(const fs::path& of)
    : file(of), before(checkpoint_before(of)), beside(of.string() + ".new") {}

bool write_checkpoint_file(const CheckpointPlaces& places,
                           const CheckpointStamp& stamp,
                           std::span<const std::uint8_t> content,
                           const polhode_key* key) {
  FileHeader header = header_of(stamp, content);
  if (key != nullptr && !sign(*key, content, &header)) {
    return false;
  }
  header.header_crc32 = crc_of(header);
  const int out =
      ::open(places.beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0640);
  if (out < 0) {
    return false;
  }
  const bool written = write_all(out, &header, sizeof header) &&
                       write_all(out, content.data(), content.size()) && ::fsync(out) == 0;
  const bool closed = ::close(out) == 0;
  if (written && closed) {
    (void)::rename(places.file.c_str(), places.before.c_str());  // at first there is none
  }
  if (!written || !closed || ::rename(places.beside.c_str(), places.file.c_str()) != 0) {
    (void)::unlink(places.beside.c_str());
    return false;
  }
  sync_folder_of(places.file);
  return true;
}

LoadedCheckpoint checkpoint_in_memory(const Component& component, const CheckpointStamp& stamp) {
  LoadedCheckpoint made;
  made.memory = std::make_unique<TableMemory>(sizeof(FileHeader) + checkpoint_octets_max());
  const std::span<std::uint8_t> whole{reinterpret_cast<std::uint8_t*>(made.memory->span().data()),
                                      made.memory->span().size()};
  const std::size_t bytes = save_checkpoint(component, whole.subspan(sizeof(FileHeader)));
  made.content = whole.subspan(sizeof(FileHeader), bytes);
  FileHeader header = header_of(stamp, made.content);
  header.header_crc32 = crc_of(header);
  std::memcpy(whole.data(), &header, sizeof header);
  made.bytes = whole.first(sizeof header + bytes);
  return made;
}

LoadedCheckpoint load_whole_checkpoint(const fs::path& file, const BuildId& build) {
  FileHeader header;
  return validated(load(file, build, &header));
}

LoadedCheckpoint load_checkpoint_file(const fs::path& file,
                                      const CheckpointIdentity& identity,
                                      const Moment& now,
                                      double age_s_max,
                                      const polhode_key* key) {
  FileHeader header;
  LoadedCheckpoint loaded = load(file, identity.build_id, &header);
  if (loaded.refusal.empty()) {
    loaded.refusal = loaded.stranger.empty() ? foreign_in(header, identity) : loaded.stranger;
  }
  if (loaded.refusal.empty() && key != nullptr && !is_signed_by(*key, header, loaded.content)) {
    loaded.refusal = "not signed by the key of commands";
  }
  loaded.age_s = age_s(header, now);
  if (loaded.refusal.empty() && !(loaded.age_s >= 0.0 && loaded.age_s <= age_s_max)) {
    loaded.refusal = fmt::format("{:.0f} s old, allowed are 0 .. {:.0f}", loaded.age_s, age_s_max);
  }
  return validated(std::move(loaded));
}

}  // namespace polhode::platform
