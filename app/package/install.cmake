# What `cmake --install` and CPack hand to others: the program, the libraries with their headers, and a CMake
# package. Users of the libraries need Eigen and OpenCV's core; everything else stays inside the shared libraries.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/ballservo)

install(TARGETS ballservo RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS ballservo_program LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS base camera color circles pictures camera_files calibration perception control servo loop visp_adapters simulation EXPORT ballservoTargets
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
foreach(folder calibration perception servo app/loop)
  cmake_path(GET folder PARENT_PATH parent)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ballservo/${parent}
          FILES_MATCHING PATTERN "*.hpp")
endforeach()
install(EXPORT ballservoTargets NAMESPACE ballservo:: DESTINATION ${package_dir})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/ballservoConfig.cmake.in
                              ${PROJECT_BINARY_DIR}/package/ballservoConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/ballservoConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/package/ballservoConfig.cmake
              ${PROJECT_BINARY_DIR}/package/ballservoConfigVersion.cmake DESTINATION ${package_dir})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/data/ DESTINATION ${CMAKE_INSTALL_DATADIR}/ballservo)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/app/python/ DESTINATION lib/python3/dist-packages
        PATTERN __pycache__ EXCLUDE PATTERN *.cpp EXCLUDE)
install(TARGETS python_module LIBRARY DESTINATION lib/python3/dist-packages/ballservo)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ballservo)
set(CPACK_PACKAGE_CONTACT "The ballservo developers <ballservo@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS
    ${PROJECT_BINARY_DIR}/calibration ${PROJECT_BINARY_DIR}/perception ${PROJECT_BINARY_DIR}/servo
    ${PROJECT_BINARY_DIR}/app)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-matplotlib, python3-jinja2, python3-numpy")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libeigen3-dev, libopencv-dev")
include(CPack)
