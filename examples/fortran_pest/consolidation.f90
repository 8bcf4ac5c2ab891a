! One-dimensional consolidation of a layer that drains at its top (Terzaghi).
! Reads consolidation.dat with fixed columns, writes consolidation.out. kN, m, day.
program consolidation
  implicit none
  integer, parameter :: dp = kind(1.0d0), terms = 200
  real(dp), parameter :: pi = 3.14159265358979324d0, gamma_w = 9.81d0
  character(len=24) :: label
  real(dp) :: height, load, modulus, permeability, cv, tv, m, final_settlement, degree, excess
  real(dp), allocatable :: days(:)
  integer :: count, i, j

  open (10, file='consolidation.dat', status='old')
  read (10, '(a24,f12.0)') label, height
  read (10, '(a24,f12.0)') label, load
  read (10, '(a24,f14.0)') label, modulus
  read (10, '(a24,f14.0)') label, permeability
  read (10, '(a24,i12)') label, count
  allocate (days(count))
  read (10, '(8f10.0)') days
  close (10)

  open (20, file='consolidation.out', status='replace')
  write (20, '(a)') ' CONSOLIDATION  1.2     ONE-DIMENSIONAL, DRAINED AT THE TOP'
  write (20, '(a,f8.2,a,f8.2,a)') ' LAYER OF', height, ' M UNDER A LOAD OF', load, ' KPA'
  if (modulus <= 0.0_dp .or. permeability <= 0.0_dp) then
    write (20, '(a)') ' *** INPUT ERROR: STIFFNESS AND PERMEABILITY MUST BE POSITIVE'
    stop                                    ! with exit status 0, as many old programs do
  end if
  cv = permeability * modulus / gamma_w
  final_settlement = load * height / modulus
  write (20, '(a,es12.4,a)') ' COEFFICIENT OF CONSOLIDATION', cv, ' M2/DAY'
  write (20, '(/,a)') ' SETTLEMENT OF THE SURFACE'
  do i = 1, count
    tv = cv * days(i) / height**2
    degree = 1.0_dp
    do j = 0, terms
      m = 0.5_dp * pi * (2 * j + 1)
      degree = degree - 2.0_dp / m**2 * exp(-m**2 * tv)
    end do
    write (20, '(a,i3,a,f9.2,a,f11.5,a,f6.1,a)') ' READING', i, ' AFTER', days(i), ' DAYS:', &
      1000.0_dp * degree * final_settlement, ' MM   (U =', 100.0_dp * degree, ' %)'
  end do
  write (20, '(/,a)') ' EXCESS PORE PRESSURE AT THE BASE'
  do i = 1, count
    tv = cv * days(i) / height**2
    excess = 0.0_dp
    do j = 0, terms
      m = 0.5_dp * pi * (2 * j + 1)
      excess = excess + 2.0_dp * load / m * (-1)**j * exp(-m**2 * tv)
    end do
    write (20, '(a,i3,a,f9.2,a,f11.5,a)') ' READING', i, ' AFTER', days(i), ' DAYS: U =', excess, ' KPA'
  end do
  write (20, '(/,a)') ' END OF CALCULATION'
end program consolidation
