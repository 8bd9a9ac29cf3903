# What `cmake --install` and the Debian package hold: the program, its libraries with headers and find_package(Talus), the
# scripts and cases, man page, completions, reference. Included by the top CMakeLists.txt.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(share ${CMAKE_INSTALL_DATADIR}/talus)
# A package needs neither tests nor benchmarks: what it holds has to be built before (talus, talus_docs).
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)

# Texts that the program makes from its own tables.
set(docs ${CMAKE_BINARY_DIR}/docs)
set(made)
foreach(pair "reference reference.md" "man talus.1" "bash talus.bash" "zsh _talus")
  separate_arguments(words UNIX_COMMAND "${pair}")
  list(GET words 0 topic)
  list(GET words 1 file)
  add_custom_command(OUTPUT ${docs}/${file} COMMAND ${CMAKE_COMMAND} -E make_directory ${docs}
                     COMMAND $<TARGET_FILE:talus> help ${topic} > ${docs}/${file} DEPENDS talus)
  list(APPEND made ${docs}/${file})
endforeach()
add_custom_target(talus_docs ALL DEPENDS ${made})

install(TARGETS talus RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
foreach(part core kernels scheduler)
  set_target_properties(talus_${part} PROPERTIES EXPORT_NAME ${part})
  install(TARGETS talus_${part} EXPORT TalusTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(DIRECTORY ${part} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/talus FILES_MATCHING PATTERN "*.hpp")
endforeach()
target_include_directories(talus_core INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/talus>)
target_compile_features(talus_core INTERFACE cxx_std_20)
set(config ${CMAKE_INSTALL_LIBDIR}/cmake/Talus)
install(EXPORT TalusTargets NAMESPACE Talus:: DESTINATION ${config})
configure_package_config_file(cases/TalusConfig.cmake.in ${CMAKE_BINARY_DIR}/TalusConfig.cmake INSTALL_DESTINATION ${config})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/TalusConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/TalusConfig.cmake ${CMAKE_BINARY_DIR}/TalusConfigVersion.cmake DESTINATION ${config})

install(FILES perf/report.py DESTINATION ${share}/perf)
install(DIRECTORY perf/report DESTINATION ${share}/perf FILES_MATCHING PATTERN "*.py" PATTERN "*.js" PATTERN "__pycache__" EXCLUDE)
install(DIRECTORY cases DESTINATION ${share} FILES_MATCHING
        PATTERN "*.toml" PATTERN "*.stl" PATTERN "*.obj" PATTERN "*.sh" PATTERN "*.py" PATTERN "*.md" PATTERN "*.png"
        PATTERN "__pycache__" EXCLUDE PATTERN "generated" EXCLUDE)
install(FILES ${docs}/talus.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${docs}/talus.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME talus)
install(FILES ${docs}/_talus DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)
install(FILES ${docs}/reference.md README.md .github/CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME talus)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_VENDOR "Talus")
set(CPACK_PACKAGE_CONTACT "Talus developers <talus@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Discrete element method for granular material")
set(CPACK_PACKAGE_DESCRIPTION "Spheres, frictional contact laws, moving walls and meshes on one multi-core node. The\n\
trajectory is a function of the scene alone: the same bits for every list policy, thread count and instruction set.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3, python3-numpy, python3-matplotlib")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "paraview, python3-h5py")
include(CPack)
