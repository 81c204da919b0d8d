// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/detail/vtk_errors.hpp"

#include <dlfcn.h>
#include <exception>
#include <vtkCommand.h>

#include "io/detail/text.hpp"

namespace nav::io::detail {

VtkErrors::VtkErrors() {
  callback_->SetClientData(&first_);
  callback_->SetCallback([](vtkObject*, unsigned long event, void* client, void* data) {
    auto& first = *static_cast<std::string*>(client);
    if (event != vtkCommand::ErrorEvent || !first.empty()) return;
    // Format: "ERROR: In file, line N\nvtkClass (0x…): message\n\n". Only the message is used.
    std::string_view all = data != nullptr ? static_cast<const char*>(data) : "VTK error";
    if (const auto colon = all.find("): "); colon != std::string_view::npos) {
      all.remove_prefix(colon + 3);
    }
    first = trim(all);
    for (char& c : first) {
      if (c == '\n') c = ' ';
    }
    if (first.empty()) first = "VTK error";
  });
}

void VtkErrors::watch(vtkObject* object) {
  object->AddObserver(vtkCommand::ErrorEvent, callback_);
  object->AddObserver(vtkCommand::WarningEvent, callback_);  // Keeps warnings off the terminal.
}

void VtkErrors::run(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::exception& thrown) {
    if (first_.empty()) first_ = std::string("exception: ") + thrown.what();
  }
}

void silence_gdcm() {
  // Debian's vtk-dicom links GDCM, but its headers are not a dependency. These two functions have
  // no arguments. If they do not exist, there are no messages to turn off.
  static const bool done = [] {
    for (const char* name : {"_ZN4gdcm5Trace10WarningOffEv", "_ZN4gdcm5Trace8ErrorOffEv"}) {
      if (void* symbol = ::dlsym(RTLD_DEFAULT, name)) reinterpret_cast<void (*)()>(symbol)();
    }
    return true;
  }();
  (void)done;
}

}  // namespace nav::io::detail
