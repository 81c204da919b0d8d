// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vtkCallbackCommand.h>
#include <vtkNew.h>
#include <vtkObject.h>

namespace nav::io::detail {

/// Keeps the first error of the VTK objects that it watches; with an observer VTK prints nothing.
/// Must outlive their use.
class VtkErrors {
 public:
  VtkErrors();
  void watch(vtkObject* object);
  /// One line; empty when nothing went wrong.
  [[nodiscard]] const std::string& first() const { return first_; }

 private:
  vtkNew<vtkCallbackCommand> callback_;
  std::string first_;
};

}  // namespace nav::io::detail
