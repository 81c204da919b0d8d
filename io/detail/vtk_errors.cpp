// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/detail/vtk_errors.hpp"

#include <vtkCommand.h>

#include "io/detail/text.hpp"

namespace nav::io::detail {

VtkErrors::VtkErrors() {
  callback_->SetClientData(&first_);
  callback_->SetCallback([](vtkObject*, unsigned long event, void* client, void* data) {
    auto& first = *static_cast<std::string*>(client);
    if (event != vtkCommand::ErrorEvent || !first.empty()) return;
    // "ERROR: In file, line N\nvtkClass (0x…): message\n\n": the message is what matters.
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
  object->AddObserver(vtkCommand::WarningEvent, callback_);  // Kept off the terminal only.
}

}  // namespace nav::io::detail
