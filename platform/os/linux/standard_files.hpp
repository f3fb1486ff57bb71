// The files that every program has, and signals that stand for errors of writing.
#pragma once

namespace polhode::platform {

/// First in main(). Where standard input, output or error is closed, the next file that is opened
/// would become it, and take what is printed: each is opened on /dev/null. What is printed to a
/// standard output that was closed fails. A limit on the size of files and a closed pipe become
/// errors of writing, too, which name the file.
void prepare_standard_files();

}  // namespace polhode::platform
