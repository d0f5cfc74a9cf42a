# Read by cpack: what depends on the version that a package gets, see deploy/package.
set(CPACK_DEBIAN_DAEMON_PACKAGE_DEPENDS
  "dccast-worker (= ${CPACK_PACKAGE_VERSION}), systemd | systemd-sysusers, systemd | systemd-tmpfiles")
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE ${CPACK_DCCAST_DOC_DIRECTORY}/changelog "dccast (${CPACK_PACKAGE_VERSION}) stable; urgency=medium

  * Release notes are in NEWS.md.gz.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}
")
file(COPY_FILE ${CPACK_DCCAST_RELEASE_NOTES} ${CPACK_DCCAST_DOC_DIRECTORY}/NEWS.md)
execute_process(COMMAND gzip -9nf changelog NEWS.md WORKING_DIRECTORY ${CPACK_DCCAST_DOC_DIRECTORY} COMMAND_ERROR_IS_FATAL ANY)
