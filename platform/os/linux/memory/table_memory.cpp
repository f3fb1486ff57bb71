#include "os/linux/memory/table_memory.hpp"

#include <sys/mman.h>

#include <string>

#include "errors.hpp"

namespace polhode::platform {

TableMemory::TableMemory(std::size_t bytes) : bytes_(bytes) {
  void* p = ::mmap(
      nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (p == MAP_FAILED) {
    throw RunFailure(std::to_string(bytes) +
                     " octets of memory for the component are not to be had");
  }
  data_ = static_cast<std::byte*>(p);
}

TableMemory::~TableMemory() { ::munmap(data_, bytes_); }

}  // namespace polhode::platform
