#include "os/linux/build_id.hpp"

#include <elf.h>
#include <link.h>

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace polhode::platform {
namespace {

constexpr std::size_t kAlignment = 4;  // of a note's name and content

std::size_t aligned(std::size_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

/// Looks through one segment of notes.
void take_from(const std::uint8_t* notes, std::size_t bytes, BuildId* id) {
  constexpr char kName[] = "GNU";
  ElfW(Nhdr) note;
  for (std::size_t at = 0; at + sizeof note <= bytes;) {
    std::memcpy(&note, notes + at, sizeof note);
    const std::size_t name = at + sizeof note;
    const std::size_t content = name + aligned(note.n_namesz);
    const std::size_t end = content + aligned(note.n_descsz);
    if (end > bytes) {
      return;
    }
    if (note.n_type == NT_GNU_BUILD_ID && note.n_namesz == sizeof kName &&
        std::memcmp(notes + name, kName, sizeof kName) == 0) {
      std::memcpy(id->data(), notes + content, std::min<std::size_t>(note.n_descsz, id->size()));
    }
    at = end;
  }
}

/// Called with the program first, then with its shared libraries.
int take_program(dl_phdr_info* info, std::size_t /*size*/, void* id) {
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const auto& part = info->dlpi_phdr[i];
    if (part.p_type == PT_NOTE) {
      take_from(reinterpret_cast<const std::uint8_t*>(info->dlpi_addr + part.p_vaddr),
                part.p_memsz,
                static_cast<BuildId*>(id));
    }
  }
  return 1;  // no further
}

}  // namespace

BuildId this_build() {
  BuildId id{};
  dl_iterate_phdr(take_program, &id);
  return id;
}

}  // namespace polhode::platform
