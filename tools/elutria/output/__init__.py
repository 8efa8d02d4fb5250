"""What people look at: figures, tables on a terminal, files for ParaView."""
