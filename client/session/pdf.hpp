#pragma once

#include <filesystem>
#include <string>

namespace dccast::client {

/// Prints an HTML page to a PDF file by Chromium, without a window.
/// Throws CommandFailed: there is no Chromium, or it wrote no PDF within a minute.
void print_pdf(const std::string& page, const std::filesystem::path& file);

}  // namespace dccast::client
