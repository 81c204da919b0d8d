// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/on_demand.hpp"

#include <dlfcn.h>
#include <string>

namespace nav {

Result<const void*> functions_on_demand(const std::filesystem::path& library, const char* name) {
  const auto failed = [&](const std::string& found) {
    return Error{ErrorCode::kUnavailable,
                 library.string() + ": expected a part of Sonde, found " + found};
  };
  // Global: libraries that it loads in turn are looked up by name.
  void* loaded = ::dlopen(library.c_str(), RTLD_LAZY | RTLD_GLOBAL);
  if (loaded == nullptr) return failed(::dlerror());
  using Functions = const void* (*)();
  const auto functions = reinterpret_cast<Functions>(::dlsym(loaded, name));
  if (functions == nullptr) return failed(std::string("a library without ") + name);
  return functions();
}

std::filesystem::path library_of_program(const std::filesystem::path& file,
                                         const std::filesystem::path& installed) {
  std::error_code none;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", none).parent_path();
  const auto beside = folder / file;
  if (std::filesystem::exists(beside, none)) return beside;
  return (folder / installed / file).lexically_normal();
}

}  // namespace nav
