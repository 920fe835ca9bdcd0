"""The nonlinear cable loop in time, with an audit of its own error."""
