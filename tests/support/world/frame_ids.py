"""Names of frames as clients may send them."""

from hypothesis import strategies as st

FRAME_IDS = st.text(st.characters(exclude_categories=["Cc", "Cs", "Zl", "Zp"]), max_size=9)
"""Names without control characters and line separators, which ``FrameId`` refuses."""
