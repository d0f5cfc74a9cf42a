# Every outside package, found once. The Debian packages that bring them stand in deploy/packages.txt.
find_package(Threads REQUIRED)
find_package(Protobuf REQUIRED)  # module mode: Debian's 3.21 ships no config file
find_package(gRPC CONFIG REQUIRED)
find_package(fmt CONFIG REQUIRED)
find_package(spdlog CONFIG REQUIRED)
find_package(CLI11 CONFIG REQUIRED)
find_package(SQLite3 REQUIRED)
find_package(tomlplusplus CONFIG REQUIRED)
find_package(nlohmann_json CONFIG REQUIRED)
find_package(HDF5 1.10 REQUIRED COMPONENTS C HL)
find_package(Eigen3 3.4 CONFIG REQUIRED NO_MODULE)
find_package(Boost 1.74 REQUIRED)  # Asio, which needs headers alone
find_package(OpenSSL REQUIRED COMPONENTS Crypto SSL)
find_package(Boost 1.74 REQUIRED)  # headers alone
find_package(Udunits2 REQUIRED)
find_package(ZLIB REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(Mosquitto REQUIRED IMPORTED_TARGET libmosquitto)
find_package(Cholmod REQUIRED)
find_package(OpenMP REQUIRED COMPONENTS CXX)  # to keep CHOLMOD on one core
