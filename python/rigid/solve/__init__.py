"""One motion: methods, closed forms, plan, integration, error estimate, sensitivity, chaos.

Uses ``model``, ``rotations``, ``_checks`` and the core; it uses neither maps nor reports. Maps,
reports, closed-form quantities and the textbook modules use it.
"""
