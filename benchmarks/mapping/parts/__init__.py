"""Parts of ``ppaas bench slam``: each measures figures that have bars."""
