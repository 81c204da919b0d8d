// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/patient_page.hpp"

#include <QFileDialog>
#include <QVBoxLayout>

#include "app/window/flow_layout.hpp"

namespace nav::app {

PatientPage::PatientPage(QWidget* parent)
    : QWidget(parent),
      path_(small_field(QStringLiteral("ct-path"), QStringLiteral("DICOM folder or file of a CT"),
                        this)),
      open_(small_button(QStringLiteral("ct-open"), QStringLiteral("Open"),
                         QStringLiteral("Read this CT in the background"), this)),
      file_(small_button(QStringLiteral("ct-file"), QStringLiteral("File…"),
                         QStringLiteral("Choose a file"), this)),
      folder_(small_button(QStringLiteral("ct-folder"), QStringLiteral("DICOM folder…"),
                           QStringLiteral("Choose a folder of DICOM files"), this)),
      cancel_(small_button(QStringLiteral("ct-cancel"), QStringLiteral("Cancel"),
                           QStringLiteral("Keep the CT that is shown"), this)),
      words_(small_label({}, this)) {
  setObjectName(QStringLiteral("patient-page"));
  setAccessibleName(QStringLiteral("Patient"));
  words_->setObjectName(QStringLiteral("ct-words"));
  words_->setAccessibleName(QStringLiteral("About the CT"));
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(6, 6, 6, 6);
  column->setSpacing(4);
  column->addWidget(small_label(QStringLiteral("Open another CT: DICOM folder, NIfTI, NRRD, "
                                               "MetaImage"),
                                this));
  auto* row = new FlowLayout(4);
  row->addWidget(path_);
  row->addWidget(open_);
  column->addLayout(row);
  auto* more = new FlowLayout(4);
  more->addWidget(file_);
  more->addWidget(folder_);
  more->addWidget(cancel_);
  column->addLayout(more);
  column->addWidget(words_);
  column->addStretch(1);
  QObject::connect(open_, &QPushButton::clicked, this, [this] {
    if (open) open();
  });
  QObject::connect(path_, &QLineEdit::returnPressed, this, [this] {
    if (open) open();
  });
  QObject::connect(cancel_, &QPushButton::clicked, this, [this] {
    if (cancel) cancel();
  });
  QObject::connect(file_, &QPushButton::clicked, this, [this] { browse(false); });
  QObject::connect(folder_, &QPushButton::clicked, this, [this] { browse(true); });
  set_busy(false);
}

void PatientPage::set_busy(bool busy) {
  cancel_->setEnabled(busy);
  open_->setEnabled(!busy);
}

/// Opens a dialog that does not stop the window.
void PatientPage::browse(bool folder) {
  auto* dialog = new QFileDialog(
      this, folder ? QStringLiteral("DICOM folder of a CT") : QStringLiteral("File of a CT"));
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setOption(QFileDialog::DontUseNativeDialog);
  dialog->setFileMode(folder ? QFileDialog::Directory : QFileDialog::ExistingFile);
  QObject::connect(dialog, &QFileDialog::fileSelected, this,
                   [this](const QString& chosen) { path_->setText(chosen); });
  dialog->open();
}

}  // namespace nav::app
