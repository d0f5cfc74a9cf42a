"""A CA of the tests' own, made by the program openssl, for certificates with any name and dates."""
import os
import subprocess
import time


def openssl_time(seconds_from_now):
    return time.strftime("%Y%m%d%H%M%SZ", time.gmtime(time.time() + seconds_from_now))


class TestCa:
    """ca.pem and ca.key in a folder; certificates share that key."""

    def __init__(self, folder):
        self.folder = folder
        self.key = os.path.join(folder, "ca.key")
        self.certificate = os.path.join(folder, "ca.pem")
        self.openssl("req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256",
                     "-nodes", "-subj", "/CN=test CA", "-days", "30", "-keyout", "ca.key", "-out",
                     "ca.pem")
        self.write("ca.conf",
                   "[ca]\ndefault_ca=own\n[own]\ndatabase=index\nserial=serial\nnew_certs_dir=.\n"
                   "certificate=ca.pem\nprivate_key=ca.key\ndefault_md=sha256\npolicy=any\n"
                   "unique_subject=no\ncopy_extensions=copy\n[any]\ncommonName=supplied\n")
        self.write("index", "")
        self.write("serial", "01\n")

    def write(self, name, text):
        with open(os.path.join(self.folder, name), "w", encoding="ascii") as file:
            file.write(text)

    def openssl(self, *words):
        subprocess.run(["openssl", *words], cwd=self.folder, capture_output=True, check=True,
                       timeout=30)

    def issue(self, file="x.pem", subject="x", name="IP:127.0.0.1", begins="20200101000000Z",
              ends="20700101000000Z"):
        """A certificate for a server of this name, or a client of this subject. Returns its path."""
        self.openssl("req", "-new", "-key", "ca.key", "-subj", "/CN=" + subject, "-addext",
                     "subjectAltName=" + name, "-out", "x.csr")
        self.openssl("ca", "-batch", "-config", "ca.conf", "-startdate", begins, "-enddate", ends,
                     "-in", "x.csr", "-out", file + ".new", "-notext")
        os.replace(os.path.join(self.folder, file + ".new"), os.path.join(self.folder, file))
        return os.path.join(self.folder, file)
